"""Reads a MATLAB file into the same table as a CSV: its vectors are the columns, those of a structure named `structure.field`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat

from config.errors import LogError
from config.whole_file import system_advice
from recording.importing.table import Floats, SourceTable


def read_mat(path: Path) -> SourceTable:
    """The numeric vectors of the length that most of them have; scalars, texts and vectors of other lengths are left out.

    LogError for a file of MATLAB 7.3 (HDF5), an unreadable one, and one without vectors.
    """
    try:
        content = loadmat(path, squeeze_me=True, struct_as_record=False)
    except OSError as error:
        reason = error.strerror or str(error)
        raise LogError("the table cannot be opened", value=reason, where=str(path), next_step=system_advice(error)) from error
    except NotImplementedError as error:
        advice = "Save it with save('NAME.mat', '-v7') in MATLAB, or export a CSV."
        raise LogError("this MATLAB file is of format 7.3 (HDF5)", where=str(path), next_step=advice) from error
    except Exception as error:  # scipy's reader raises whatever the bytes lead it to
        advice = "Save it again, or export a CSV."
        raise LogError("this is no MATLAB file", value=str(error)[:80], where=str(path), next_step=advice) from error
    vectors = dict(_vectors({name: value for name, value in content.items() if not name.startswith("__")}, ""))
    if not vectors:
        advice = "It needs one vector of numbers per signal, all of one length."
        raise LogError("the MATLAB file has no vectors", value=", ".join(content)[:80], where=str(path), next_step=advice)
    lengths = [len(values) for values in vectors.values()]
    rows = max(set(lengths), key=lambda n: (lengths.count(n), n))
    columns = {name: values for name, values in vectors.items() if len(values) == rows}
    return SourceTable(path, columns, np.arange(1, rows + 1, dtype=np.int64))


def _vectors(node: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Floats]]:
    """Named vectors of numbers, also inside structures and timeseries-like ones; a matrix gives a column each, numbered from 1."""
    for name, value in node.items():
        if hasattr(value, "_fieldnames"):
            yield from _vectors({field: getattr(value, field) for field in value._fieldnames}, f"{prefix}{name}.")
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub":
            if value.ndim == 1 and len(value) > 1:
                yield prefix + name, np.ascontiguousarray(value, dtype=np.float64)
            elif value.ndim == 2:
                for k in range(value.shape[1]):
                    yield f"{prefix}{name}.{k + 1}", np.ascontiguousarray(value[:, k], dtype=np.float64)
