"""Why did B lose? The contests, refusals and highlights of a recorded match as facts, and the facts in words."""

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
from catch_arena.explanation.sight import Unseen
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
