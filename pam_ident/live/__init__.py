"""Figures to zoom and to point at, for the workbench and for the page of a report. They need Bokeh, an extra."""
