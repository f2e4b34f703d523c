"""Starts a program that cannot read or write the processor's extended registers by ptrace: `python without_xstate.py PROGRAM ARGUMENTS`.

A user-mode Linux 6.1 stops at its first process where these registers are larger than it knows (AMX: "ptrace set fp regs failed").
Refused their reading, it keeps the SSE registers alone, as it does on an old processor.
"""

from __future__ import annotations

import ctypes
import errno
import os
import struct
import sys

PR_SET_SECCOMP, PR_SET_NO_NEW_PRIVS, SECCOMP_MODE_FILTER = 22, 38, 2
SYS_PTRACE, PTRACE_GETREGSET = 101, 0x4204  # x86-64
LOAD, JUMP_IF_EQUAL, RETURN = 0x20, 0x15, 0x06  # BPF: a word of the call; (code, if true, if false, value)
NUMBER, FIRST_ARGUMENT = 0, 16  # where struct seccomp_data has them
ALLOW, REFUSE = 0x7FFF0000, 0x00050000 | errno.EINVAL
FILTER = (
    (LOAD, 0, 0, NUMBER),
    (JUMP_IF_EQUAL, 0, 3, SYS_PTRACE),
    (LOAD, 0, 0, FIRST_ARGUMENT),
    (JUMP_IF_EQUAL, 0, 1, PTRACE_GETREGSET),
    (RETURN, 0, 0, REFUSE),
    (RETURN, 0, 0, ALLOW),
)


class Program(ctypes.Structure):
    """struct sock_fprog."""

    _fields_ = (("length", ctypes.c_ushort), ("instructions", ctypes.c_char_p))


def refuse_extended_registers() -> None:
    """For this process and all it starts."""
    program = Program(len(FILTER), b"".join(struct.pack("HBBI", *instruction) for instruction in FILTER))
    libc = ctypes.CDLL(None, use_errno=True)
    for option in ((PR_SET_NO_NEW_PRIVS, 1, 0), (PR_SET_SECCOMP, SECCOMP_MODE_FILTER, ctypes.byref(program))):
        if libc.prctl(*option, 0, 0) != 0:
            raise OSError(ctypes.get_errno(), "seccomp refused")


if __name__ == "__main__":
    refuse_extended_registers()
    os.execvp(sys.argv[1], sys.argv[1:])
