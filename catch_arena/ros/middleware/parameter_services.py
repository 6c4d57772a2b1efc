"""The services by which `ros2 param` and others read and change a node's parameters: ROS's rcl_interfaces.

Over rclpy a node has them of itself. Answers are those of rclpy's: where one name is unknown, the list is empty.
"""

from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

from catch_arena.ros.middleware.bus import Request
from catch_arena.ros.middleware.interfaces import ServiceType, message_type, service_type
from catch_arena.ros.middleware.parameters import Parameter, Parameters, Value

_NOT_SET, _BOOL, _INTEGER, _DOUBLE, _STRING = range(5)
"""rcl_interfaces/msg/ParameterType; five kinds of arrays follow, which no parameter here has."""
_TYPES: Final[dict[type, int]] = {bool: _BOOL, int: _INTEGER, float: _DOUBLE, str: _STRING}


class ParameterValue(NamedTuple):
    """rcl_interfaces/msg/ParameterValue: `type` says which of the others counts."""

    type: int = _NOT_SET
    bool_value: bool = False
    integer_value: int = 0
    double_value: float = 0.0
    string_value: str = ""
    byte_array_value: tuple[int, ...] = ()
    bool_array_value: tuple[bool, ...] = ()
    integer_array_value: tuple[int, ...] = ()
    double_array_value: tuple[float, ...] = ()
    string_array_value: tuple[str, ...] = ()

    @classmethod
    def of(cls, value: Value) -> "ParameterValue":
        """What stands for it on the bus."""
        kind = _TYPES[type(value)]
        return cls(kind, **{cls._fields[kind]: value})  # type: ignore[arg-type]

    @property
    def value(self) -> object:
        """What it stands for; None where nothing is set, or of a type that ROS does not have."""
        return self[self.type] if 0 < self.type < len(self) else None


class NamedValue(NamedTuple):
    """rcl_interfaces/msg/Parameter."""

    name: str
    value: ParameterValue


class FloatRange(NamedTuple):
    """rcl_interfaces/msg/FloatingPointRange."""

    from_value: float
    to_value: float
    step: float


class IntegerRange(NamedTuple):
    """rcl_interfaces/msg/IntegerRange."""

    from_value: int
    to_value: int
    step: int


class Descriptor(NamedTuple):
    """rcl_interfaces/msg/ParameterDescriptor."""

    name: str
    type: int
    description: str
    additional_constraints: str
    read_only: bool
    dynamic_typing: bool = False
    floating_point_range: tuple[FloatRange, ...] = ()
    integer_range: tuple[IntegerRange, ...] = ()

    @classmethod
    def of(cls, parameter: Parameter) -> "Descriptor":
        """What there is to say about one."""
        kind = _TYPES[type(parameter.value)]
        return cls(parameter.name, kind, parameter.description, parameter.fixed, read_only=bool(parameter.fixed))


class Listed(NamedTuple):
    """rcl_interfaces/msg/ListParametersResult."""

    names: tuple[str, ...]
    prefixes: tuple[str, ...]


class Changed(NamedTuple):
    """rcl_interfaces/msg/SetParametersResult."""

    successful: bool
    reason: str


class Wanted(NamedTuple):
    """The request of rcl_interfaces/srv/ListParameters: what names begin with, and how many parts they have."""

    prefixes: tuple[str, ...]
    depth: int


class One(NamedTuple):
    """A request or a response with one field, whatever ROS calls that."""

    field: Any


VALUE: Final = message_type(
    "rcl_interfaces/msg/ParameterValue",
    ParameterValue,
    "uint8 type",
    "bool bool_value",
    "int64 integer_value",
    "float64 double_value",
    "string string_value",
    "uint8 byte_array_value[]",  # ROS calls them byte; on the wire they are the same
    "bool bool_array_value[]",
    "int64 integer_array_value[]",
    "float64 double_array_value[]",
    "string string_array_value[]",
)
NAMED_VALUE: Final = message_type("rcl_interfaces/msg/Parameter", NamedValue, "string name", (VALUE, "value"))
FLOAT_RANGE: Final = message_type(
    "rcl_interfaces/msg/FloatingPointRange", FloatRange, "float64 from_value", "float64 to_value", "float64 step"
)
INTEGER_RANGE: Final = message_type(
    "rcl_interfaces/msg/IntegerRange", IntegerRange, "int64 from_value", "int64 to_value", "uint64 step"
)
DESCRIPTOR: Final = message_type(
    "rcl_interfaces/msg/ParameterDescriptor",
    Descriptor,
    "string name",
    "uint8 type",
    "string description",
    "string additional_constraints",
    "bool read_only",
    "bool dynamic_typing",
    (FLOAT_RANGE, "floating_point_range[]"),
    (INTEGER_RANGE, "integer_range[]"),
)
LISTED: Final = message_type("rcl_interfaces/msg/ListParametersResult", Listed, "string names[]", "string prefixes[]")
CHANGED: Final = message_type("rcl_interfaces/msg/SetParametersResult", Changed, "bool successful", "string reason")
LIST: Final = service_type(
    "rcl_interfaces/srv/ListParameters", (Wanted, "string prefixes[]", "uint64 depth"), (One, (LISTED, "result"))
)
DESCRIBE: Final = service_type(
    "rcl_interfaces/srv/DescribeParameters", (One, "string names[]"), (One, (DESCRIPTOR, "descriptors[]"))
)
GET: Final = service_type("rcl_interfaces/srv/GetParameters", (One, "string names[]"), (One, (VALUE, "values[]")))
GET_TYPES: Final = service_type("rcl_interfaces/srv/GetParameterTypes", (One, "string names[]"), (One, "uint8 types[]"))
SET: Final = service_type(
    "rcl_interfaces/srv/SetParameters", (One, (NAMED_VALUE, "parameters[]")), (One, (CHANGED, "results[]"))
)
SET_ATOMICALLY: Final = service_type(
    "rcl_interfaces/srv/SetParametersAtomically", (One, (NAMED_VALUE, "parameters[]")), (One, (CHANGED, "result"))
)
SERVICES: Final = {
    "list_parameters": LIST,
    "describe_parameters": DESCRIBE,
    "get_parameters": GET,
    "get_parameter_types": GET_TYPES,
    "set_parameters": SET,
    "set_parameters_atomically": SET_ATOMICALLY,
}
"""All of them: rclpy's client of another node's parameters waits for each."""


def serve_parameters(
    serve: Callable[[str, ServiceType, Callable[[Request], object]], None], node: str, parameters: Parameters
) -> None:
    """Answer for a node.

    Args:
        serve: the bus's.
        node: what it is called.
        parameters: its own.
    """

    def of_each(names: Sequence[str], tell: Callable[[Parameter], Any]) -> One:
        return One(tuple(tell(parameters[name]) for name in names) if all(name in parameters for name in names) else ())

    def listed(wanted: Wanted) -> One:
        names = tuple(one.name for one in parameters if not wanted.prefixes or one.name in wanted.prefixes)
        return One(Listed(names, ()))

    def changed(*asked: NamedValue) -> Changed:
        reason = parameters.change([(one.name, one.value.value) for one in asked])
        return Changed(not reason, reason)

    answers: dict[str, Callable[[Any], One]] = {
        "list_parameters": listed,
        "describe_parameters": lambda asked: of_each(asked.field, Descriptor.of),
        "get_parameters": lambda asked: of_each(asked.field, lambda one: ParameterValue.of(one.value)),
        "get_parameter_types": lambda asked: of_each(asked.field, lambda one: _TYPES[type(one.value)]),
        "set_parameters": lambda asked: One(tuple(map(changed, asked.field))),
        "set_parameters_atomically": lambda asked: One(changed(*asked.field)),
    }
    for name, answer in answers.items():
        serve(f"/{node}/{name}", SERVICES[name], _answering(answer))


def _answering(answer: Callable[[Any], One]) -> Callable[[Request], None]:
    return lambda request: request.answer(answer(request.message))
