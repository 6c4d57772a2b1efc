"""Keys and a gamepad drive a hunter and control the window."""

import pytest

from catch_arena.live.user_input import HumanPolicy, user_command
from catch_arena.render.optional_imports import pygame


def key(code: int, *, down: bool = True, mod: int = 0, typed: str = ""):
    return pygame.event.Event(pygame.KEYDOWN if down else pygame.KEYUP, key=code, mod=mod, unicode=typed)


def held(*codes: int) -> HumanPolicy:
    person = HumanPolicy()
    for code in codes:
        person.handle(key(code))
    return person


@pytest.mark.parametrize(
    ("codes", "linear", "turn"),
    [
        ([pygame.K_UP], 1, 0),
        ([pygame.K_w], 1, 0),
        ([pygame.K_DOWN], -1, 0),
        ([pygame.K_s], -1, 0),
        ([pygame.K_LEFT], 0, 1),  # counter-clockwise, as in turtlesim
        ([pygame.K_d], 0, -1),
        ([pygame.K_UP, pygame.K_RIGHT], 1, -1),
        ([pygame.K_UP, pygame.K_s], 0, 0),
        ([pygame.K_LEFT, pygame.K_d], 0, 0),
        ([pygame.K_x], 0, 0),
    ],
)
def test_turtlesims_keys_drive_and_so_do_wasd(codes, linear, turn):
    person = held(*codes)
    commands = [person.act(None) for _ in range(5)]
    assert {command[0] for command in commands} == {linear}
    assert commands[-1][1] == turn


def test_a_turn_grows_while_its_key_is_held_and_begins_anew_the_other_way():
    person = held(pygame.K_LEFT)
    turns = [person.act(None)[1] for _ in range(4)]
    assert turns == sorted(turns)
    assert 0 < turns[0] < turns[1] < turns[2] == turns[3] == 1
    person.handle(key(pygame.K_LEFT, down=False))
    person.handle(key(pygame.K_RIGHT))
    assert person.act(None)[1] == -turns[0]


def test_a_tap_between_two_steps_counts_for_one():
    person = held(pygame.K_UP)
    person.handle(key(pygame.K_UP, down=False))
    assert [person.act(None)[0] for _ in range(3)] == [1, 0, 0]


def test_what_was_held_is_let_go_with_the_window():
    person = held(pygame.K_UP)
    person.handle(pygame.event.Event(pygame.WINDOWFOCUSLOST))
    assert person.act(None) == (0, 0)


def test_ctrl_s_saves_and_does_not_drive():
    event = key(pygame.K_s, mod=pygame.KMOD_LCTRL)
    assert user_command(event) == "save"
    person = HumanPolicy()
    person.handle(event)
    assert person.act(None) == (0, 0)


def test_no_key_that_drives_asks_the_window_for_anything():
    """One key, one meaning, whether the match is paused or not."""
    codes = {value for name, value in vars(pygame).items() if name.startswith("K_")}
    driving = [code for code in codes if any(held(code).act(None))]
    assert len(driving) == 13  # arrows, WASD, and the keypad's 8 4 6 2 5
    assert not any(user_command(key(code, typed=pygame.key.name(code))) for code in driving)
    assert user_command(key(pygame.K_q, typed="q")) is None  # between W and A


@pytest.mark.parametrize(
    ("event", "command"),
    [
        (key(pygame.K_SPACE), "pause"),
        (key(pygame.K_p), "pause"),
        (key(pygame.K_n, typed="n"), "step"),
        (key(pygame.K_PERIOD, typed="."), "step"),
        (key(pygame.K_r), "restart"),
        (key(pygame.K_SEMICOLON, typed="."), "step"),  # a French keyboard
        (key(pygame.K_r, mod=pygame.KMOD_LCTRL), None),
        (key(pygame.K_ESCAPE), "quit"),
        (key(pygame.K_h), "help"),
        (key(pygame.K_EQUALS, typed="="), "faster"),
        (key(pygame.K_KP_PLUS, typed="+"), "faster"),
        (key(pygame.K_SLASH, typed="-"), "slower"),  # a German keyboard
        (key(pygame.K_UP), None),
        (key(pygame.K_p, down=False), None),
        (pygame.event.Event(pygame.QUIT), "quit"),
        (pygame.event.Event(pygame.JOYBUTTONDOWN, button=7), "pause"),
        (pygame.event.Event(pygame.JOYBUTTONDOWN, button=0), None),
    ],
)
def test_what_the_window_is_asked_for(event, command):
    assert user_command(event) == command


def test_a_stick_drives_in_proportion_and_its_dead_zone_is_no_command():
    person = HumanPolicy()
    for axis, value in ((0, -0.6), (1, -1.0)):
        person.handle(pygame.event.Event(pygame.JOYAXISMOTION, axis=axis, value=value))
    linear, angular = person.act(None)
    assert linear == 1.0
    assert 0.4 < angular < 0.6  # to the left
    for axis in (0, 1):
        person.handle(pygame.event.Event(pygame.JOYAXISMOTION, axis=axis, value=0.1))
    assert person.act(None) == (0, 0)


def test_a_pads_cross_and_button_drive_too():
    person = HumanPolicy()
    person.handle(pygame.event.Event(pygame.JOYBUTTONDOWN, button=0))
    person.handle(pygame.event.Event(pygame.JOYHATMOTION, value=(1, 0)))
    assert person.act(None)[0] == 1
    assert person.act(None)[1] < 0
    person.handle(pygame.event.Event(pygame.JOYBUTTONUP, button=0))
    person.handle(pygame.event.Event(pygame.JOYHATMOTION, value=(0, 0)))
    assert person.act(None) == (0, 0)
