"""What a person sees: the page in Debian's Chromium, over the whole program and virtual cars.

A package, so that the browser's fixtures end with this folder: Playwright keeps an event loop on
the main thread as long as it runs, and no other test may then start one.
"""
