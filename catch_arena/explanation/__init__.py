"""Why did B lose? The contests, refusals and highlights of a recorded match as facts, and the facts in words."""

from catch_arena.explanation.match_summary import Claim, Contest, Explanation, HunterSummary, Refusals, explain
from catch_arena.explanation.sight import Unseen
from catch_arena.explanation.step_explanation import HunterAction, StepExplanation, explain_step

__all__ = [
    "Claim",
    "Contest",
    "Explanation",
    "HunterAction",
    "HunterSummary",
    "Refusals",
    "StepExplanation",
    "Unseen",
    "explain",
    "explain_step",
]
