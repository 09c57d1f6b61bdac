"""Motions and bodies of others: tables of what was measured or computed elsewhere, and files for
other programs.
"""
