"""How a motion answers to a change of its numbers: derivatives along a run, and how fast nearby
motions part.
"""
