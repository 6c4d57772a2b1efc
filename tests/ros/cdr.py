"""CDR and the layout of ROS services a second time: by hand, from the description of the wire alone."""

import struct

LITTLE_ENDIAN = b"\x00\x01\x00\x00"


class Writer:
    """Writes numbers at multiples of their size, counted from the fifth byte."""

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

    def whole(self):
        return LITTLE_ENDIAN + bytes(self.body)


class Reader:
    """Reads the bytes of a Writer."""

    def __init__(self, data):
        assert data[:4] == LITTLE_ENDIAN
        self.body, self.at = data[4:], 0

    def number(self, code):
        size = struct.calcsize(f"<{code}")
        self.at += -self.at % size
        (value,) = struct.unpack_from(f"<{code}", self.body, self.at)
        self.at += size
        return value

    def text(self):
        length = self.number("I")
        raw = self.body[self.at : self.at + length]
        self.at += length
        assert raw[-1:] == b"\0"
        return raw[:-1].decode()


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
    """Return a Writer with the header of requests and responses."""
    return Writer().number("Q", client).number("q", number)
