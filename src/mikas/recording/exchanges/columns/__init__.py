"""The exchanges of a recording array by array, where numpy is whole."""
