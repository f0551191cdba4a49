"""What `pathspace stability` leaves to Python: a second evaluation, Mitsuba's side, the picture."""
