"""Pages and drawings that are made from the program, so that they are never stale.

tables         tables of Markdown, and the words in them
catalog_pages  parameters, faults, derived channels, models, errata
causes_page    causes, and the features that they move
command_pages  the commands of the protocol
protocol_page  the worked bytes in the protocol itself
bodies         requests and responses in words
frames         frames on the line, drawn
install_page   the packages of an installation and their megabytes
places         generated places of pages that people edit
help_pages     what every command says to --help
python_pages   the Python interface, from its docstrings
writing        which of them are files of the repository, and which are on the site only
"""
