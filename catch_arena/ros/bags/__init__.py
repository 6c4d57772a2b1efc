"""Recordings of a bus: rosbag2.

- files: its files. service_events: recorded calls of a service.
- export: a replay becomes a bag.
- reading: a bag is read. contents: what it tells of turtlesim. rulings: what the arbiter would have answered. video: a
  video of it.
"""
