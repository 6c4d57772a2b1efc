"""Grading of a class: a folder of submissions becomes marks.csv, and a page for each student; see
docs/howto/grading.md.

- submissions: who submitted what, and when. similarity: submissions that are equal, or nearly equal.
- grading: all submissions in parallel, each kept as soon as it is graded. nodes: ROS 2 nodes, one after the other.
- moments: the moment of a match that an agent's page plays. student_page: the page of a student. marks: marks.csv.
- starters: the files of `new-agent` and `new-class`.
"""
