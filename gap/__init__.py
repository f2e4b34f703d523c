"""Where model and measurement disagree, and the name of what is missing.

Six rooms, each importing only from those before it; `find` is the whole way through them, `loop` and `study` go it many times.

- data: a log as it is: its channels and their faults, noise, windows
- balance: equations formed from measurements alone, and what makes them uneven
- fitting: the model on windows of a log: simulation, start states, cost, sensitivities, least squares
- search: candidates, screening, trials, acceptance, verdict, smallest visible sizes
- maneuvers: which move or sensor would separate explanations
- report: findings, the improved rig file, what is left, pictures and page
"""
