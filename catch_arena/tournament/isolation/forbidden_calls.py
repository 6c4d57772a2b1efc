"""System calls that agents do without: those that take memory or leave things behind where no limit counts them, and
those that change the limits of other processes.

A filter of the kernel (seccomp) answers the former as a kernel that does not have them, so that libraries take other
ways, and the latter as where another user's process is meant. It holds for a process and all that it starts, at both
levels, and for root too.
"""

import ctypes
import errno
import struct
from typing import Final

from catch_arena.descendants import LINUX

# <linux/audit.h>: the machine that a call is made for, and <asm/unistd.h>: its numbers
_CALLS: Final = {
    0xC000003E: {  # x86-64
        "shmget": 29,
        "semget": 64,
        "msgget": 68,
        "mq_open": 240,
        "add_key": 248,
        "request_key": 249,
        "keyctl": 250,
        "vmsplice": 278,
        "memfd_create": 319,
        "io_uring_setup": 425,
        "memfd_secret": 447,
    },
    0x40000003: {  # x86, 32 bits
        "ipc": 117,
        "mq_open": 277,
        "add_key": 286,
        "request_key": 287,
        "keyctl": 288,
        "vmsplice": 316,
        "memfd_create": 356,
        "semget": 393,
        "shmget": 395,
        "msgget": 399,
        "io_uring_setup": 425,
        "memfd_secret": 447,
    },
    0xC00000B7: {  # ARM, 64 bits
        "vmsplice": 75,
        "mq_open": 180,
        "msgget": 186,
        "semget": 190,
        "shmget": 194,
        "add_key": 217,
        "request_key": 218,
        "keyctl": 219,
        "memfd_create": 279,
        "io_uring_setup": 425,
        "memfd_secret": 447,
    },
    0x40000028: {  # ARM, 32 bits
        "ipc": 117,
        "mq_open": 274,
        "semget": 299,
        "msgget": 303,
        "shmget": 307,
        "add_key": 309,
        "request_key": 310,
        "keyctl": 311,
        "vmsplice": 343,
        "memfd_create": 385,
        "io_uring_setup": 425,
        "memfd_secret": 447,
    },
}
"""On other machines nothing is forbidden."""
_PRLIMIT: Final = {0xC000003E: 302, 0x40000003: 340, 0xC00000B7: 261, 0x40000028: 369}
"""The call that sets a process's limits, by machine: allowed where it names its own as 0, as libraries do."""
_X32: Final = 0x40000000
"""From here on x86-64 has other numbers, for programs with short pointers, which hardly any kernel runs: all are
forbidden.
"""

# <linux/bpf_common.h>, <linux/seccomp.h>, <linux/prctl.h>
_LOAD, _EQUAL, _AT_LEAST, _RETURN = 0x20, 0x15, 0x35, 0x06
_NUMBER, _MACHINE, _FIRST_ARGUMENT = 0, 4, 16  # of the last its lower half, where the lower half comes first
_ALLOW, _ERRNO = 0x7FFF0000, 0x00050000
_SET_SECCOMP, _FILTER = 22, 2
_instruction: Final = struct.Struct("@HBBI")


def forbid_calls() -> None:
    """Forbid them to this process and to those that it starts. It has given up new privileges (PR_SET_NO_NEW_PRIVS)."""
    if not LINUX:
        return
    code = _program()
    kept = ctypes.create_string_buffer(code, len(code))
    form = struct.pack("@HP", len(code) // _instruction.size, ctypes.addressof(kept))
    ctypes.CDLL(None).prctl(_SET_SECCOMP, _FILTER, ctypes.c_char_p(form), 0, 0)


def _program() -> bytes:
    """In the kernel's language: what is done with a call; jumps say how many instructions are left out."""
    lines: list[tuple[int, int, int, int]] = []
    for machine, calls in _CALLS.items():
        numbers = sorted(calls.values())
        lines += [
            (_LOAD, 0, 0, _MACHINE),
            (_EQUAL, 0, len(numbers) + 8, machine),  # else on to the next machine
            (_LOAD, 0, 0, _NUMBER),
            (_AT_LEAST, len(numbers) + 4, 0, _X32),
        ]
        lines += [(_EQUAL, len(numbers) + 3 - place, 0, number) for place, number in enumerate(numbers)]
        lines += [
            (_EQUAL, 0, 2, _PRLIMIT[machine]),
            (_LOAD, 0, 0, _FIRST_ARGUMENT),
            (_EQUAL, 0, 2, 0),
            (_RETURN, 0, 0, _ALLOW),
            (_RETURN, 0, 0, _ERRNO | errno.ENOSYS),
            (_RETURN, 0, 0, _ERRNO | errno.EPERM),
        ]
    lines.append((_RETURN, 0, 0, _ALLOW))
    return b"".join(_instruction.pack(*line) for line in lines)
