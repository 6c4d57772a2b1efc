"""Why did B lose? The contests, refusals and highlights of a recorded match as facts, and the facts in words.

- match_summary: a whole match. step_explanation: all about one step. highlights: what is worth seeing.
- facts: what is told, as data; found by contests, captures (of prey) and seen_targets (who saw which target).
- sentences: facts in words, with formatting for lengths and times. seats: which hunter is meant.
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
    "explain",
    "explain_step",
    "step_at",
]
