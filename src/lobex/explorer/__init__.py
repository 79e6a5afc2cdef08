"""The explorer: lobes that follow the numbers of a model, on a page that this machine alone sees, or in a notebook.

It takes panel and bokeh: ``pip install 'lobex[explore]'``. All that a screen shows follows from its state (``state``),
which is a link (``addresses``), a process (``recipes``) and a script (``script``); ``curves`` and ``point`` compute it.
"""
