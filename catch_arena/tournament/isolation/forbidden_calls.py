"""System calls that agents do without: those that take memory or leave things behind where no limit counts them.

A filter of the kernel (seccomp) answers them as a kernel that does not have them, so that libraries take other ways. It
holds for a process and all that it starts, at both levels, and for root too.
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
_X32: Final = 0x40000000
"""From here on x86-64 has other numbers, for programs with short pointers, which hardly any kernel runs: all are
forbidden.
"""

# <linux/bpf_common.h>, <linux/seccomp.h>, <linux/prctl.h>
_LOAD, _EQUAL, _AT_LEAST, _RETURN = 0x20, 0x15, 0x35, 0x06
_NUMBER, _MACHINE = 0, 4
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
            (_EQUAL, 0, len(numbers) + 4, machine),  # else on to the next machine
            (_LOAD, 0, 0, _NUMBER),
            (_AT_LEAST, len(numbers) + 1, 0, _X32),
        ]
        lines += [(_EQUAL, len(numbers) - place, 0, number) for place, number in enumerate(numbers)]
        lines += [(_RETURN, 0, 0, _ALLOW), (_RETURN, 0, 0, _ERRNO | errno.ENOSYS)]
    lines.append((_RETURN, 0, 0, _ALLOW))
    return b"".join(_instruction.pack(*line) for line in lines)
