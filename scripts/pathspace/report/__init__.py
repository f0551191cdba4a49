"""The report of an experiment: one HTML file that needs nothing else.

    python -m pathspace.report DIR
    python -m pathspace.report DIR -o paper/report.html --no-images

DIR is the folder of an experiment; the report is written into it as report.html. It holds plots of
error over time and over samples, a viewer of the images with their values, the tables, and what it
takes to repeat the experiment. All of it comes from the files in DIR, and no number is computed
anew; values of images are kept in half precision.
"""

from .page import page, write_report

__all__ = ["page", "write_report"]
