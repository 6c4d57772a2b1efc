"""Matches in a window while they are played: a person in a seat, or agents alone.

`keys` says what keys and gamepads mean, `person` drives a hunter by them, `cards` are what is written over the arena,
`show` is the window, and `session` plays.
"""
