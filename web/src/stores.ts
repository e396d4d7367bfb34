// All that a page knows, in one object: made for each page, handed to its components by context. What belongs to the window instead is a module's
// own: language, theme, frame clock, width classes, the identity of the tab.
import { createContext } from "svelte";
import { createApi } from "./lib/api/api";
import { CatalogStore } from "./lib/api/catalog.svelte";
import { CarDetails } from "./lib/car/carDetails.svelte";
import { ChannelCard } from "./lib/channels/channelCard.svelte";
import { ChannelEditor } from "./lib/channels/channelEditor.svelte";
import { Control } from "./lib/control/control.svelte";
import { Naming } from "./lib/control/markers.svelte";
import { RecordingControl } from "./lib/control/recordingControl.svelte";
import { Subscriptions } from "./lib/control/subscriptions.svelte";
import { Cursors } from "./lib/display/cursors.svelte";
import { Moments } from "./lib/display/moments.svelte";
import { AbsentChannels } from "./lib/display/absent.svelte";
import { Display } from "./lib/display/source.svelte";
import { Route } from "./lib/frame/router.svelte";
import { Shortcuts } from "./lib/frame/shortcuts";
import { Toasts } from "./lib/frame/toasts.svelte";
import { AlarmBuzz } from "./lib/live/alarmBuzz.svelte";
import { AlarmSound } from "./lib/live/alarmSound.svelte";
import { PageActions } from "./lib/live/pageActions.svelte";
import { actionTeller } from "./lib/live/actionNews";
import { faultTeller } from "./lib/live/faultNews";
import { instrumentTeller } from "./lib/live/instrumentNews";
import { Live } from "./lib/live/live.svelte";
import { WhileAway } from "./lib/live/whileAway";
import { Battery } from "./lib/platform/battery.svelte";
import { FullScreen } from "./lib/platform/fullScreen.svelte";
import type { Host } from "./lib/platform/host";
import { WakeLock } from "./lib/platform/wakeLock.svelte";
import { Comparison } from "./lib/recording/comparison.svelte";
import { Player } from "./lib/recording/player.svelte";
import { ValueRanges, WARM_IDLE } from "./lib/recording/valueRanges.svelte";
import { Choice } from "./screens/chart/paired/choice.svelte";
import { ChartData } from "./screens/chart/time/data/sources";
import { Find } from "./screens/chart/time/find/find.svelte";
import { Reference } from "./screens/chart/time/reference/reference.svelte";
import { ChartMoves } from "./screens/chart/time/shortcuts";
import { TraceDrag } from "./screens/chart/time/traceDrag.svelte";
import { View } from "./screens/chart/time/view.svelte";
import { CauseStore } from "./screens/causes/store.svelte";
import { ConnectionStore } from "./screens/connection/store.svelte";
import { InstrumentStore } from "./screens/connection/instruments/store.svelte";
import { SurveyStore } from "./screens/connection/survey/store.svelte";
import { FaultStore } from "./screens/faults/store.svelte";
import { Big } from "./screens/live/big/big.svelte";
import { Presets } from "./screens/live/presets.svelte";
import { MemoryStore } from "./screens/memory/store.svelte";
import { PassportStore } from "./screens/passport/store.svelte";
import { Comparing } from "./screens/recordings/compare/comparing.svelte";
import { RecordingStore } from "./screens/recordings/store.svelte";
import { CoStore } from "./screens/tests/co/store.svelte";
import { RecordedTests } from "./screens/tests/recorded.svelte";
import { Tests } from "./screens/tests/store.svelte";

/** Its fields are there before those of `Stores`, which are made with them. */
class OnHost {
  constructor(readonly host: Host) {}
}

export class Stores extends OnHost {
  readonly api = createApi(this.host);
  readonly toasts = new Toasts(this.api);
  readonly route = new Route();
  readonly shortcuts = new Shortcuts();
  readonly fullScreen = new FullScreen();
  readonly wakeLock = new WakeLock();

  readonly live = new Live(this.host, this.api);
  readonly alarmSound = new AlarmSound(this.live);
  readonly alarmBuzz = new AlarmBuzz(this);
  readonly pageActions = new PageActions(this.alarmSound);
  readonly whileAway = new WhileAway(this);
  readonly battery = new Battery(this);
  readonly control = new Control(this.live);
  readonly catalog = new CatalogStore(this);
  readonly channelCard = new ChannelCard();
  readonly channelEditor = new ChannelEditor();

  readonly cursors = new Cursors();
  readonly moments = new Moments(this.cursors);
  readonly display = new Display(this.live);
  readonly absent = new AbsentChannels(this.display);
  readonly comparison = new Comparison(this.api);
  readonly player = new Player(this.api, this.comparison, this.display);
  readonly warmIdle = new ValueRanges(this, () => WARM_IDLE);

  readonly subscriptions = new Subscriptions(this);
  readonly naming = new Naming(this);
  readonly carDetails = new CarDetails(this);
  readonly recordingControl = new RecordingControl(this);

  readonly presets = new Presets(this);
  readonly big = new Big(this);

  readonly view = new View(this);
  readonly traceDrag = new TraceDrag(this.view);
  readonly chartData = new ChartData(this);
  readonly reference = new Reference(this);
  readonly find = new Find(this);
  readonly moves = new ChartMoves(this);
  readonly choice = new Choice();

  readonly faults = new FaultStore(this);
  readonly tests = new Tests(this);
  readonly co = new CoStore(this);
  readonly recorded = new RecordedTests(this.api);
  readonly causes = new CauseStore(this);
  readonly passports = new PassportStore(this);
  readonly memory = new MemoryStore(this.api);
  readonly recordings = new RecordingStore(this);
  readonly comparing = new Comparing(this);
  readonly connection = new ConnectionStore(this);
  readonly survey = new SurveyStore(this);
  readonly instruments = new InstrumentStore(this);

  constructor(host: Host) {
    super(host);
    const { catalog, channelEditor, comparison, display, live, memory, moments, player, route, toasts, view } = this;
    const tellers = [faultTeller(this), actionTeller(this), instrumentTeller(this)];
    live.onevents = (events) => tellers.forEach((tell) => tell(events));
    live.onother = () => memory.drop();
    // On the first visit without a connection, start at the Connection screen.
    live.onfirst = ({ line }) => line === "off" && location.hash === "" && route.go("connection");
    catalog.onrecomputed = (names) => {
      live.reload(names);
      void toasts.attempt(() => Promise.all([player.reload(), comparison.reload()]));
    };
    moments.onturn = (moment) => view.bringMoment(moment);
    comparison.onshown = () => view.showAll();
    comparison.onforeign = (log) => {
      catalog.lent = log?.channels ?? [];
      view.lend(log?.detail.channels ?? []);
    };
    channelEditor.ondeleted = (name) => view.remove(name);
    // Another source, on any screen: the chart follows live data, or shows the recording completely; the cursors of the one before mean nothing.
    display.onshown = () => view.begin(display.source.kind === "live" ? "live" : (player.detail?.id ?? ""));
    display.onshown();
  }
}

export const [useStores, provideStores] = createContext<Stores>();
