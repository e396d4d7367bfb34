"""For the tests of programs that use mikas, and of links of one's own; needs pytest.

    def test_warns_when_hot(car, virtual_ecu):           # fixtures of `mikas.testing.plugin`
        car.set("TWAT", 110)
        assert warning_of(virtual_ecu)

`units.VirtualUnit` is a unit on a wire with simulated time, which can pass without a request;
`links.LinkContract` is the suite that every link of mikas passes.
"""
