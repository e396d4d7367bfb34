// Width classes of the window: `narrow` is too narrow for wide tables (phone, tablet), `phone` is a phone.
import { MediaQuery } from "svelte/reactivity";

export const narrow = new MediaQuery("max-width: 1000px");
export const phone = new MediaQuery("max-width: 700px");
