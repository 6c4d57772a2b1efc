"""Why did B lose? The contests, refusals and highlights of a recorded match as facts, and the facts in words."""

from catch_arena.explanation.captures import Capture, PreySummary
from catch_arena.explanation.match_summary import (
    Claim,
    Contest,
    Explanation,
    HunterSummary,
    Refusals,
    TeamSummary,
    explain,
)
from catch_arena.explanation.sight import Unseen
from catch_arena.explanation.step_explanation import HunterAction, PreyAction, StepExplanation, explain_step

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
]
