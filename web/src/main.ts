import { mount } from "svelte";
import App from "./App.svelte";
import { served } from "./lib/platform/host";
import { Stores } from "./stores";
import "./styles/tokens.css";
import "./styles/base.css";
import "uplot/dist/uPlot.min.css";

mount(App, { target: document.getElementById("page")!, props: { stores: new Stores(served) } });
