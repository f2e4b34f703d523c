"""What is said of a finished search: shares of the posterior, the hold-out as judge, votes, and the words.

Imports `noise` and `score`, and the search's state from the files beside this room.
"""
