"""What a log holds: the fields of a cycle's record, their layout and ROS 2 schema, and events.

Imports config. The daemon packs records with it; every room of recording imports it.
"""
