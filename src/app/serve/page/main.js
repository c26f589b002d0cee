/* Puts the page together. */
import "./log.js";

import {connect} from "./connection.js";
import {begin_keep} from "./keep.js";
import {begin_methods} from "./methods.js";
import {begin_panels, show_panel} from "./panels.js";
import {begin_passes} from "./passes.js";
import {begin_picture} from "./picture.js";
import {begin_scene_panel} from "./scene_panel.js";
import {begin_status} from "./status.js";
import {begin_story} from "./story.js";
import {begin_time} from "./time.js";
import {begin_view} from "./view.js";
import {on} from "./world.js";

begin_panels();
begin_picture();
begin_view();
begin_methods();
begin_scene_panel();
begin_story();
begin_passes();
begin_status();
begin_time();
begin_keep();

on("picked", () => show_panel("scene"));
on("pass-chosen", () => show_panel("method"));
on("tool", tool => tool === "pixel" && show_panel("pixel"));

connect();
