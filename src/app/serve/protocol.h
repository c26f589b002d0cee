/* What `softlux serve` and its page say to each other over one WebSocket, /socket?TOKEN.
 *
 * Text is one JSON object: to the server with "do", to the page with "is". Lengths are in scene units, angles
 * in degrees, colours linear; columns and rows of pixels count from the top left. Objects, materials and
 * lights have the library's numbers, from 1. Sides are "a" and "b"; "a" where none is named. A message that
 * is malformed (no object, no known "do", a value of another type or size, too long or too deep, too many at
 * a time) ends the connection with a reason; what is well formed and cannot be is answered by "refused".
 *
 * The page is at /, its token in the fragment: http://127.0.0.1:PORT/#TOKEN.
 *
 * ---- to the server
 *
 *   {"do":"camera","eye":[3],"target":[3],"up":[3],"fov":40}       up and fov may be left out: as they are
 *   {"do":"reset"}                                                 the camera, and the scene's own time
 *   {"do":"time","at":1.5}      {"do":"play","on":true}
 *   {"do":"size","width":w,"height":h}                             16 to 2048 a side
 *   {"do":"method","side":"a","name":"splatting","settings":{"quality":"draft"}}    name "": b goes away
 *   {"do":"pick","x":..,"y":..}
 *   {"do":"edit","edits":[...],"drag":true}                        drag: more of the same follow, one undo
 *       {"kind":"object","object":3,"matrix":[12]}                 three rows of four, the last column moves;
 *                                                                  from where the scene's file has it; null:
 *                                                                  back there, or to its keyframes
 *       {"kind":"material","material":2,"diffuse":[3],"specular":[3],"exponent":..,"mirror":[3],
 *        "emission":[3]}
 *       {"kind":"light","light":1,"power":[3],"position":[3],"direction":[3]}        what is left out stays;
 *                                                                  power: W/sr, or W/m^2 of directional ones;
 *                                                                  "scale":2 in its place multiplies
 *       {"kind":"add-light","position":[3],"power":[3]}            a point
 *       {"kind":"remove-light","light":1}                          it stays in the list, dark
 *       {"kind":"sky","stops":1}                                   from the file's sky, times 2^stops
 *       {"kind":"sun","direction":[3]}                             of the brightest directional light
 *   {"do":"undo"}  {"do":"redo"}
 *   {"do":"story","side":"a","x":..,"y":..}
 *   {"do":"passes","side":"a","on":true}                           the method starts anew, observed
 *   {"do":"overlay","side":"a","kind":"records"}                   a pass's name, or part of it; "": none. Of
 *                                                                  a side whose passes are on
 *   {"do":"reference","on":true}    {"do":"difference","on":true}    {"do":"error","on":true}
 *   {"do":"exact","side":"a"}       {"do":"exact","on":false}      leaves off
 *   {"do":"keep","what":"png"|"exr"|"scene"|"log"|"page"|"film"}   film: begins, and ends with the next one
 *   {"do":"tone","exposure":0,"curve":"reinhard"|"clip","auto":true}
 *   {"do":"got","frame":n}                                         two frames without it are the most sent;
 *                                                                  n: the greatest number got
 *
 * Messages that change the scene (camera, reset, time, edit, undo, redo) are events, numbered from 1
 * for the whole server: the newest one that a frame shows stands in its header. {"is":"did","event":n,
 * "do":".."} answers every message but "got", "pick" and "story", n being the newest event by then.
 *
 * ---- to the page
 *
 *   {"is":"hello","version","event","size":[w,h],"methods":[..],"settings":[{name,methods,unit,symbol,help,
 *       minimum,maximum,default,everyday}],"scene":{...},"sides":{"a":"splatting","b":""},"tone":{...}}
 *   {"is":"scene",name,triangles,camera:{eye,target,up,fov},time,duration,plays,
 *       objects:[{object,name,material,centre,bounds:[6],matrix:[12]}],
 *       materials:[{material,name,diffuse,specular,exponent,mirror,emission,textured}],
 *       lights:[{light,type,position,direction,power}],sky:{present,stops},undo:n,redo:n}
 *                                                                  after edits, too, and as keyframes move
 *                                                                  things
 *   {"is":"camera",eye,target,up,fov,time}                         somebody moved it (also to that one)
 *   {"is":"state","side":"a","method","seconds","batches","done",
 *       "counters":{..},"kept":{"event":n,"changes":[..],"counters":{"before":{..},"since":{..}}},
 *       "latency":ms,"drawing":ms,"encoding":ms,"frame":n,"reduced":"..","settings":{..}}
 *                                                                  twice a second while something changes;
 *                                                                  kept: by the newest edit
 *   {"is":"picked","what":"object"|"light"|"sky","object","name","material","light","at":[3],"normal":[3],
 *       x,y}
 *   {"is":"story","side","x","y","pixel":[3],"terms":[{layer,kind,index,weight,value,contribution,
 *       at:[column,row]}],"rounding":[3],"paper":[html lines],
 *       "passes":[{pass,layer,title,text:[html lines],equation,function,source:{file,first,text}}]}
 *       contributions and rounding add up to the pixel; beyond 24 terms the rest are one, of layer "several"
 *   {"is":"pass","side","index","place","name","source","times","counters","width","height","marks",title,
 *       text,equation,function}                                    as a story's; place: in the paper's order;
 *                                                                  marks: so many can be drawn over;
 *                                                                  its picture follows as a frame of kind 3
 *   {"is":"overlay","side","kind","pass","width","height","svg":"<path .../><circle .../>..."}
 *   {"is":"method","side","name","settings":{..}}                  somebody chose it
 *   {"is":"reference","samples","done"}
 *   {"is":"error","side","seconds","error"}                        a share; what a reference's own noise adds
 *                                                                  is in it
 *   {"is":"exact","side","fraction","done","command","png","exr"}  png, exr: addresses, once it is done;
 *                                                                  what a frame of kind 6 shows
 *   {"is":"kept","what","name","href","bytes"}                     also of png and exr, once they are made
 *   {"is":"refused","do","reason"}                                 of a method also late, with its side: it
 *                                                                  is made beside all else
 *   {"is":"viewers","count"}
 *
 * ---- pictures: binary, little-endian, SL_FRAME_HEADER bytes and then a JPEG's or PNG's
 *
 *   u32 "SLFR"; u8 kind; u8 format (0 JPEG, 1 PNG); u16 index of the pass (and 64 of side b), or the side (0:
 *   a, 1: b) of other kinds; u32 number of the frame; u16 width; u16 height; u64 number of the newest event
 *   that it shows.
 * JPEG while things move, PNG once they rest. Numbers of frames rise, for all kinds together. */
#pragma once

enum { SL_FRAME_HEADER = 24 };

typedef enum sl_frame_kind {
    SL_FRAME_A,
    SL_FRAME_B,
    SL_FRAME_REFERENCE,
    SL_FRAME_PASS,
    SL_FRAME_DIFFERENCE, /* of a side and the reference, in false colour */
    SL_FRAME_ERROR,      /* its square root, in brightness */
    SL_FRAME_EXACT,
    SL_FRAME_KINDS
} sl_frame_kind;

/* What a message may be. */
enum {
    SL_MESSAGE_BYTES = 16384,
    SL_MESSAGE_DEPTH = 6,
    SL_MESSAGES_A_SECOND = 240,
    SL_CLIENTS = 16,
    SL_SMALLEST_SIDE = 16,
    SL_LARGEST_SIDE = 2048
};
