"""A run, or several, as one HTML file that needs nothing else: data, page, words, plots."""
