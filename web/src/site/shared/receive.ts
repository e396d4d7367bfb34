// The service worker's end of a share: the system posts the files to the address that the manifest names. They are kept, and the page is shown.
import { CHANNEL, type Inbox, type News } from "./inbox";

/** Where the manifest's `share_target` posts to, relative to the site, and the field of the files. */
export const PATH = "shared";
const FIELD = "recordings";

/** Answer a share by the address of the page. A tab that has the program takes the files; else the page that is shown now does. */
export async function receive(request: Pick<Request, "formData">, site: URL, inbox: Inbox): Promise<Response> {
  const news = await kept(request, inbox);
  if (news === "some") {
    const channel = new BroadcastChannel(CHANNEL);
    channel.postMessage(news);
    channel.close();
  }
  return Response.redirect(new URL(`./?shared=${news}#/recordings`, site).href, 303);
}

async function kept(request: Pick<Request, "formData">, inbox: Inbox): Promise<News> {
  try {
    const given = (await request.formData()).getAll(FIELD);
    // A form without a file has one without a name.
    return await inbox.put(given.filter((it): it is File => it instanceof File && (it.name !== "" || it.size > 0)));
  } catch {
    return "failed";
  }
}
