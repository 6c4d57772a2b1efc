"""Explanations of recorded matches: contests, refusals and highlights as facts, and the facts in words.

- match_summary: a whole match. step_explanation: one step in detail. highlights: moments worth seeing.
- what_if: the smallest change of actions with which a lost contest would have been won.
- facts: the data of explanations, found by contests, captures (of prey) and seen_targets (targets in sight).
- sentences: facts in words, with formatting for lengths and times. seats: labels of agents, and selection by name.
"""

from catch_arena.explanation.facts import (
    Capture,
    Claim,
    Contest,
    HunterAction,
    HunterSummary,
    PreyAction,
    PreySummary,
    Refusals,
    TeamSummary,
)
from catch_arena.explanation.match_summary import Explanation, explain
from catch_arena.explanation.seen_targets import Unseen
from catch_arena.explanation.step_explanation import StepExplanation, explain_step, step_at
from catch_arena.explanation.what_if import WhatIf, lost_contest_at, what_if

__all__ = [
    "Capture",
    "Claim",
    "Contest",
    "Explanation",
    "HunterAction",
    "HunterSummary",
    "PreyAction",
    "PreySummary",
    "Refusals",
    "StepExplanation",
    "TeamSummary",
    "Unseen",
    "WhatIf",
    "explain",
    "explain_step",
    "lost_contest_at",
    "step_at",
    "what_if",
]
