"""From text to a model: YAML that remembers its lines, validation, and problems told with file, line and the nearest right word.

Imports `schema`. For config only; other folders load files through `loading`.
"""
