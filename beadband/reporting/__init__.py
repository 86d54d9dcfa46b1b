"""A run to look at: the page and the movie, both drawn from a :class:`~beadband.reporting.report_data.Story`."""
