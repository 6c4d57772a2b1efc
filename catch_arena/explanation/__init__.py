"""Why did B lose? The contests and refusals of a recorded match as facts, and the facts in words."""

from catch_arena.explanation.evidence import Claim, Contest, Explanation, Record, Refusals, explain
from catch_arena.explanation.steps import Asked, StepExplanation, explain_step

__all__ = [
    "Asked",
    "Claim",
    "Contest",
    "Explanation",
    "Record",
    "Refusals",
    "StepExplanation",
    "explain",
    "explain_step",
]
