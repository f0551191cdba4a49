"""Mitsuba's side of `pathspace parity`: cases, images, values, and the page."""
