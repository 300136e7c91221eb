"""Debian 12's ParaView 5.11 asks Python for inspect.getargspec when it loads a plugin, which Python 3.11 no longer has.

With this folder in PYTHONPATH, plugins in Python are loaded.
"""
import inspect

if not hasattr(inspect, "getargspec"):
    inspect.getargspec = inspect.getfullargspec
