"""Input of a person from keys and a gamepad: velocity commands for an agent, and commands for the window."""

from typing import Any, ClassVar, Final, Literal

from catch_arena.config import Control
from catch_arena.policy import PreyView, View
from catch_arena.render.optional_imports import pygame

_AHEAD: Final = {pygame.K_UP, pygame.K_w, pygame.K_KP8}
_BACK: Final = {pygame.K_DOWN, pygame.K_s, pygame.K_KP2, pygame.K_KP5}
_LEFT: Final = {pygame.K_LEFT, pygame.K_a, pygame.K_KP4}
_RIGHT: Final = {pygame.K_RIGHT, pygame.K_d, pygame.K_KP6}

_TURNS: Final = (0.45, 0.75, 1.0)
"""Parts of the turn rate in the first steps that a key is held: a tap turns a little, a held key turns sharply."""
_DEAD_ZONE: Final = 0.15
"""Part of a stick's range around its centre that gives no command."""
_GO_BUTTON: Final = 0
_PAUSE_BUTTONS: Final = (7, 9)
"""Numbers of the start button on the usual gamepads."""

UserCommand = Literal["pause", "step", "restart", "save", "quit", "help", "view", "faster", "slower"]
"""Commands for the window."""
_TYPED: Final[dict[str, UserCommand]] = {
    "+": "faster",
    "=": "faster",
    "-": "slower",
    ".": "step",
}
"""Commands by typed character, since the keys for these characters depend on the keyboard."""
_COMMANDS: Final[dict[int, UserCommand]] = {
    pygame.K_SPACE: "pause",
    pygame.K_p: "pause",
    pygame.K_r: "restart",
    pygame.K_ESCAPE: "quit",
    pygame.K_h: "help",
    pygame.K_F1: "help",
    pygame.K_v: "view",
    pygame.K_n: "step",
}
"""Commands by key. No key of these drives; Q is unused, since it lies next to W and A: a slip must not end a match."""


def user_command(event: Any) -> UserCommand | None:
    """Return the command for the window that an event stands for, or None."""
    if event.type == pygame.QUIT:
        return "quit"
    if event.type == pygame.JOYBUTTONDOWN:
        return "pause" if event.button in _PAUSE_BUTTONS else None
    if event.type != pygame.KEYDOWN:
        return None
    if event.mod & pygame.KMOD_CTRL:
        return "save" if event.key == pygame.K_s else None
    return _TYPED.get(getattr(event, "unicode", "")) or _COMMANDS.get(event.key)


class HumanPolicy:
    """Policy of a person who drives a hunter or prey by the keys and the gamepad's stick that it holds.

    For a hunter the nearest target in reach is requested (R4.4).
    """

    control: ClassVar[Control] = "velocity"

    def __init__(self) -> None:
        self.reset()

    def reset(self, seed: int = 0) -> None:
        """Release all keys."""
        del seed
        self._held: set[int] = set()
        self._tapped: set[int] = set()
        self._stick = [0.0, 0.0]
        self._hat = (0, 0)
        self._go = False
        self._turned = 0
        self._steps = 0

    def handle(self, event: Any) -> None:
        """Update the state from one event; events that do not drive are ignored."""
        if event.type == pygame.KEYDOWN and not event.mod & pygame.KMOD_CTRL:
            self._held.add(event.key)
            self._tapped.add(event.key)
        elif event.type == pygame.KEYUP:
            self._held.discard(event.key)
        elif event.type == pygame.JOYAXISMOTION and event.axis in {0, 1}:
            self._stick[event.axis] = event.value
        elif event.type == pygame.JOYHATMOTION:
            self._hat = event.value
        elif event.type in {pygame.JOYBUTTONDOWN, pygame.JOYBUTTONUP} and event.button == _GO_BUTTON:
            self._go = event.type == pygame.JOYBUTTONDOWN
        elif event.type in {pygame.WINDOWFOCUSLOST, pygame.JOYDEVICEREMOVED}:
            self.reset()

    def act(self, view: View | PreyView) -> tuple[float, float]:
        """Return the next step's command, linear and angular in [-1, 1]; a key that was tapped counts for one step."""
        del view
        down = self._held | self._tapped
        self._tapped = set()
        forward = _sign(bool(down & _AHEAD) or self._go or self._hat[1] > 0, bool(down & _BACK) or self._hat[1] < 0)
        turn = _sign(bool(down & _LEFT) or self._hat[0] < 0, bool(down & _RIGHT) or self._hat[0] > 0)
        self._steps = self._steps + 1 if turn and turn == self._turned else 0
        self._turned = turn
        linear, angular = float(forward), turn * _TURNS[min(self._steps, len(_TURNS) - 1)]
        return linear or _beyond(-self._stick[1]), angular or _beyond(-self._stick[0])


def _sign(positive: bool, negative: bool) -> int:
    return int(positive) - int(negative)


def _beyond(value: float) -> float:
    """Return a stick's deflection without its dead zone, in [-1, 1]."""
    if abs(value) <= _DEAD_ZONE:
        return 0.0
    part = min(1.0, (abs(value) - _DEAD_ZONE) / (1.0 - _DEAD_ZONE))
    return part if value > 0 else -part
