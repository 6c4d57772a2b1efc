"""CDR and the layout of ROS services, once more: by hand, from the description of the wire alone, byte after byte.

Nothing of the package is used here, nor of the library that it uses.
"""

import struct

LITTLE_ENDIAN = b"\x00\x01\x00\x00"


class Writer:
    """Writes numbers at multiples of their size, counted from behind the four bytes in front."""

    def __init__(self):
        self.body = bytearray()

    def number(self, code, value):
        size = struct.calcsize(f"<{code}")
        self.body += bytes(-len(self.body) % size)
        self.body += struct.pack(f"<{code}", value)
        return self

    def text(self, value):
        raw = value if isinstance(value, bytes) else value.encode()
        self.number("I", len(raw) + 1)
        self.body += raw + b"\0"
        return self

    def raw(self, value):
        """Single bytes, which stand anywhere."""
        self.body += value
        return self

    def whole(self):
        return LITTLE_ENDIAN + bytes(self.body)


class Reader:
    """Reads what a Writer writes, in either order of bytes."""

    def __init__(self, data):
        self.order = "<" if data[1] & 1 else ">"
        self.body, self.at = data[4:], 0

    def number(self, code):
        size = struct.calcsize(f"<{code}")
        self.at += -self.at % size
        (value,) = struct.unpack_from(f"{self.order}{code}", self.body, self.at)
        self.at += size
        return value

    def text(self):
        length = self.number("I")
        raw = self.body[self.at : self.at + length]
        self.at += length
        assert raw[-1:] == b"\0"
        return raw[:-1].decode()

    def rest(self):
        return self.body[self.at :]


def pose(values):
    writer = Writer()
    for value in values:
        writer.number("f", value)
    return writer.whole()


def twist(linear, angular):
    writer = Writer()
    for value in (*linear, *angular):
        writer.number("d", value)
    return writer.whole()


def turtles(listed):
    writer = Writer().number("I", len(listed))
    for name, *numbers in listed:
        writer.text(name)
        for value in numbers:
            writer.number("d", value)
    return writer.whole()


def read_turtles(data):
    reader = Reader(data)
    return [(reader.text(), *(reader.number("d") for _ in range(3))) for _ in range(reader.number("I"))]


def begin(client, number):
    """What requests and responses of a service begin with."""
    return Writer().number("Q", client).number("q", number)
