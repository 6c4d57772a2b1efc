"""What keys and a gamepad mean."""

import pytest

from catch_arena.live.keys import Hands, Wish, wish_of
from catch_arena.render.libraries import pygame


def key(code: int, *, down: bool = True, mod: int = 0, typed: str = ""):
    return pygame.event.Event(pygame.KEYDOWN if down else pygame.KEYUP, key=code, mod=mod, unicode=typed)


def held(*codes: int) -> Hands:
    hands = Hands()
    for code in codes:
        hands.take(key(code))
    return hands


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
    hands = held(*codes)
    commands = [hands.command() for _ in range(5)]
    assert {command[0] for command in commands} == {linear}
    assert commands[-1][1] == turn


def test_a_turn_grows_while_its_key_is_held_and_begins_anew_the_other_way():
    hands = held(pygame.K_LEFT)
    turns = [hands.command()[1] for _ in range(4)]
    assert turns == sorted(turns)
    assert 0 < turns[0] < turns[1] < turns[2] == turns[3] == 1
    hands.take(key(pygame.K_LEFT, down=False))
    hands.take(key(pygame.K_RIGHT))
    assert hands.command()[1] == -turns[0]


def test_a_tap_between_two_steps_counts_for_one():
    hands = held(pygame.K_UP)
    hands.take(key(pygame.K_UP, down=False))
    assert [hands.command()[0] for _ in range(3)] == [1, 0, 0]


def test_what_was_held_is_let_go_with_the_window():
    hands = held(pygame.K_UP)
    hands.take(pygame.event.Event(pygame.WINDOWFOCUSLOST))
    assert hands.command() == (0, 0)


def test_ctrl_s_saves_and_does_not_drive():
    event = key(pygame.K_s, mod=pygame.KMOD_LCTRL)
    assert wish_of(event) is Wish.SAVE
    hands = Hands()
    hands.take(event)
    assert hands.command() == (0, 0)


def test_no_key_that_drives_asks_the_window_for_anything():
    """One key, one meaning, whether the match is paused or not."""
    codes = {value for name, value in vars(pygame).items() if name.startswith("K_")}
    driving = [code for code in codes if any(held(code).command())]
    assert len(driving) == 13  # arrows, WASD, and the keypad's 8 4 6 2 5
    assert not any(wish_of(key(code, typed=pygame.key.name(code))) for code in driving)
    assert wish_of(key(pygame.K_q, typed="q")) is None  # between W and A


@pytest.mark.parametrize(
    ("event", "wish"),
    [
        (key(pygame.K_SPACE), Wish.PAUSE),
        (key(pygame.K_p), Wish.PAUSE),
        (key(pygame.K_n, typed="n"), Wish.STEP),
        (key(pygame.K_PERIOD), Wish.STEP),
        (key(pygame.K_r), Wish.AGAIN),
        (key(pygame.K_SEMICOLON, typed="."), Wish.STEP),  # a French keyboard
        (key(pygame.K_r, mod=pygame.KMOD_LCTRL), None),
        (key(pygame.K_ESCAPE), Wish.END),
        (key(pygame.K_h), Wish.HELP),
        (key(pygame.K_EQUALS, typed="+"), Wish.FASTER),
        (key(pygame.K_SLASH, typed="-"), Wish.SLOWER),  # a German keyboard
        (key(pygame.K_UP), None),
        (key(pygame.K_p, down=False), None),
        (pygame.event.Event(pygame.QUIT), Wish.END),
        (pygame.event.Event(pygame.JOYBUTTONDOWN, button=7), Wish.PAUSE),
        (pygame.event.Event(pygame.JOYBUTTONDOWN, button=0), None),
    ],
)
def test_what_the_window_is_asked_for(event, wish):
    assert wish_of(event) is wish


def test_a_stick_drives_in_proportion_and_its_dead_zone_is_no_wish():
    hands = Hands()
    for axis, value in ((0, -0.6), (1, -1.0)):
        hands.take(pygame.event.Event(pygame.JOYAXISMOTION, axis=axis, value=value))
    linear, angular = hands.command()
    assert linear == 1.0
    assert 0.4 < angular < 0.6  # to the left
    for axis in (0, 1):
        hands.take(pygame.event.Event(pygame.JOYAXISMOTION, axis=axis, value=0.1))
    assert hands.command() == (0, 0)


def test_a_pads_cross_and_button_drive_too():
    hands = Hands()
    hands.take(pygame.event.Event(pygame.JOYBUTTONDOWN, button=0))
    hands.take(pygame.event.Event(pygame.JOYHATMOTION, value=(1, 0)))
    assert hands.command()[0] == 1
    assert hands.command()[1] < 0
    hands.take(pygame.event.Event(pygame.JOYBUTTONUP, button=0))
    hands.take(pygame.event.Event(pygame.JOYHATMOTION, value=(0, 0)))
    assert hands.command() == (0, 0)
