"""Where model and measurement disagree, and the name of what is missing.

`find` is the whole way through the rooms, `loop` and `study` go it many times; `watch` goes another. Rooms, each importing only from those
before it:

- data: a log as it is: its channels and their faults, noise, windows
- balance: equations formed from measurements alone, and what makes them uneven
- fitting: the model on windows of a log: simulation, start states, cost, sensitivities, least squares
- suspects: the effects that may be missing, where to try each, and what is large there
- evidence: one score for effects and constants together, names with their probabilities
- outcome: where the gap is, what was found, the improved rig file
- maneuvers: which move or sensor would separate explanations
- remainder: what is left without a name, and how it can be kept
- report: pictures and page
- watch: numbers that wear and faults change, over the logs of weeks
"""
