// Whether the window is too narrow for a table with many columns: a phone's, a tablet's; and whether it is a phone's.
import { MediaQuery } from "svelte/reactivity";

export const narrow = new MediaQuery("max-width: 1000px");
export const phone = new MediaQuery("max-width: 700px");
