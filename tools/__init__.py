"""What builds and checks this repository; none of it is installed with the program."""
