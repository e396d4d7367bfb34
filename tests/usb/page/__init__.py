"""The page's drivers (web/src/site/usb) over the models, in Node and in Pyodide under Node."""
