"""What must hold before and while the arm moves: named checks with value, limit, unit, source and reaction.

Imports `cycle`. The loop runs them as interlocks, the server shows them (`longreach why`). Rooms:

- declared: the checks themselves, one family of them a file

`declaration` says what one consists of, `interlocks` makes those of a rig from all files of `declared`.
"""
