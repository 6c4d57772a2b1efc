"""Explanations of recorded matches: contests, refusals and highlights as facts, and the facts in words.

- match_summary: a whole match. step_explanation: one step in detail. highlights: moments worth seeing.
- what_if: the smallest change of actions with which a lost contest would have been won.
- facts: the data of explanations. contests: contests of a step, and targets out of sight.
- sentences: parts of the words, with formatting for lengths and times. seats: labels of agents, and selection by name.
"""

from catch_arena.explanation.facts import Contest as Contest
from catch_arena.explanation.match_summary import Explanation as Explanation
from catch_arena.explanation.match_summary import explain as explain
from catch_arena.explanation.step_explanation import StepExplanation as StepExplanation
from catch_arena.explanation.step_explanation import explain_step as explain_step
from catch_arena.explanation.step_explanation import step_at as step_at
from catch_arena.explanation.what_if import WhatIf as WhatIf
from catch_arena.explanation.what_if import lost_contest_at as lost_contest_at
from catch_arena.explanation.what_if import what_if as what_if
