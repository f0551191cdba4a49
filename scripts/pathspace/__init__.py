"""Mitsuba as an opponent, and plots of what a comparison found."""
