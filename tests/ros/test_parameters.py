"""Parameters after --ros-args are read as ROS reads them, or refused in one line."""

import pytest

from catch_arena.errors import ConfigError
from catch_arena.ros.nodes.parameters import parameters_from

FREQUENCY, PREFIX, CLOSEST = "spawn_frequency", "turtle_name_prefix", "catch_closest_turtle_first"
DEFAULTS = {FREQUENCY: 0.5, PREFIX: "target_turtle_", CLOSEST: False}


@pytest.mark.parametrize(
    ("words", "given"),
    [
        ((), {}),
        (("-p", f"{FREQUENCY}:=2.0"), {FREQUENCY: 2.0}),
        (("-p", f"{FREQUENCY}:=1e1", "--param", f"{FREQUENCY}:=.25"), {FREQUENCY: 0.25}),
        (("-p", f"{PREFIX}:=a2", "-p", f"{CLOSEST}:=True"), {PREFIX: "a2", CLOSEST: True}),
        (("-p", f"{CLOSEST}:=false", "-p", f"{PREFIX}:=2"), {CLOSEST: False, PREFIX: "2"}),
    ],
)
def test_a_value_has_the_type_of_its_parameter_and_the_last_one_counts(words, given):
    assert parameters_from(words, DEFAULTS) == DEFAULTS | given


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("-p",), "--ros-args must be -p NAME:=VALUE, such as -p spawn_frequency:=0.5, got '-p'"),
        (("-r", "__node:=bob"), "--ros-args must be -p NAME:=VALUE, such as -p spawn_frequency:=0.5, got '-r'"),
        ((f"{FREQUENCY}:=2.0",), f"--ros-args must be -p NAME:=VALUE, such as -p {FREQUENCY}:=0.5, got '{FREQUENCY}"),
        (("-p", "spawn_frequency=2.0"), "--ros-args -p must be NAME:=VALUE, such as spawn_frequency:=0.5"),
        (("-p", f"{FREQUENCY}:="), f"{FREQUENCY} must be a number, got ''"),
        (("-p", f"{FREQUENCY}:=fast"), f"{FREQUENCY} must be a number, got 'fast'"),
        (("-p", f"{CLOSEST}:=1"), f"{CLOSEST} must be true or false, got '1'"),
        (("-p", "spawn_freq:=2.0"), f"there is no parameter 'spawn_freq': did you mean {FREQUENCY}?"),
    ],
)
def test_a_word_that_cannot_be_is_one_line(words, why):
    with pytest.raises(ConfigError) as error:
        parameters_from(words, DEFAULTS)
    assert str(error.value).startswith(why)
    assert "\n" not in str(error.value)
