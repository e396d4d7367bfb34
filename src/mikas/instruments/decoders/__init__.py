"""The decoders: lines by a pattern, NMEA 0183, Innovate's ISP2, gpsd's JSON."""
