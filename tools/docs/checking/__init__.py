"""What `make check` holds the documents to; each module yields its findings.

finding       a place in a document, and what is wrong there
links         every link and every anchor of the Markdown leads somewhere
named         every path and every name of Python in a document exists; files of this release
structure     every page is in the navigation; a Russian page is built like the English one
sessions      a block of commands is run, and prints what it shows
examples      all blocks of code of a document, in an empty folder
built         every link of the built site leads somewhere
"""
