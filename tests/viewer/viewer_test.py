#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Drives the viewer's page in Chromium: a live run, its result, its report, a saved map, and made scenes with a loop and submaps.

  tests/viewer/viewer_test.py COVIS [--pictures FOLDER]
"""
import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy as np
    import selenium  # noqa: F401
    from PIL import Image
    if not shutil.which('chromium') or not shutil.which('chromedriver'):
        raise ImportError('there is no chromium with its driver')
except ImportError as missing:
    print(f'skipped: {missing}; tools/setup --tests installs it')
    raise SystemExit(77)

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from browser import Browser, Served  # noqa: E402
from made_scene import made_scene  # noqa: E402

# Colours of the page (web/src/colours.js).
PATH, SECOND_SUBMAP, BEFORE, LOOP = (255, 176, 46), (79, 195, 247), (154, 164, 178), (255, 77, 210)
TRACKED, LOST = (74, 222, 128), (248, 113, 113)
# True when the present image has pixels in the colour of tracked keypoints, more than there are such keypoints, on a grey picture.
KEYPOINTS_ARE_DRAWN = '''
  const tracked = covis.model.image?.keypoints.filter(k => k.kind === 0).length;
  const canvas = document.getElementById("covis-image"), {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let green = 0, grey = 0;
  for (let k = 0; k < data.length; k += 4) {
    const [r, g, b] = data.slice(k, k + 3);
    green += g > Math.max(r, b) + 40;
    grey += g > 40 && r === g && g === b;
  }
  return tracked > 0 && green > tracked && grey > 1000'''
LAYERS = ('path', 'keyFrames', 'points', 'covisibility', 'loops', 'current', 'axes')


def slowed(recording, folder, times):
    """Makes a recording of the same images (TUM), that many times slower."""
    folder.mkdir()
    for name in ('rgb', 'depth', 'camera.yaml'):
        (folder / name).symlink_to(recording / name)
    for name in ('rgb.txt', 'depth.txt'):
        rows = [line.split() for line in (recording / name).read_text().splitlines() if not line.startswith('#')]
        (folder / name).write_text(''.join(f'{times * float(stamp):.6f} {image}\n' for stamp, image in rows))


class ViewerTest(unittest.TestCase):
    covis = None
    pictures = None

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        run = [cls.covis, 'synth', 'desk', '--sensor', 'rgbd', '--frames', '60', '--width', '320', '--height', '240', '--quiet', '--out', cls.folder / 'desk']
        subprocess.run(run, check=True, capture_output=True)
        cls.browser = Browser().__enter__()
        # Everything is looked at while the command that tracked it still serves; the other cases open what it wrote.
        command = [cls.covis, 'run', cls.folder / 'desk', '--out', cls.folder / 'out', '--save-map', cls.folder / 'desk.m', '--view=0']
        cls.live = Served(command)
        cls.browser.open(cls.live.url)
        cls.browser.until('return document.getElementById("covis-mode").textContent === "finished run"')

    @classmethod
    def tearDownClass(cls):
        cls.live.__exit__()
        cls.browser.__exit__()
        cls.temporary.cleanup()

    def pixels(self, name):
        """The page as an array of rows, columns and colours, and the place of the 3D view in it."""
        folder = self.pictures or self.folder
        file = self.browser.screenshot(pathlib.Path(folder) / f'{name}.png')
        box = self.browser.js('const r = document.getElementById("covis-canvas").getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]')
        return np.asarray(Image.open(file).convert('RGB')).astype(int), [round(v) for v in box]

    def check_line(self, name, colour, points):
        """The pixels of this colour are where these points of the world are, and nowhere else."""
        # The present camera is drawn over the end of the path.
        self.browser.js('covis.page.scene.setVisible("current", false)')
        image, (left, top, right, bottom) = self.pixels(name)
        self.browser.js('covis.page.scene.setVisible("current", true)')
        found = (np.abs(image - colour).max(axis=2) <= 3)[top:bottom, left:right]
        places = self.browser.js('return arguments[0].map(covis.project)', points)
        line = self.between(places)
        inside = [(x, y) for x, y in line[::7] if 3 < x < right - left - 3 and 3 < y < bottom - top - 3]
        self.assertGreater(len(inside), 10)
        hit = [found[round(y) - 2:round(y) + 3, round(x) - 2:round(x) + 3].any() for x, y in inside]
        self.assertGreater(np.mean(hit), 0.9, f'{name}: of {len(hit)} places of the path {sum(hit)} have its colour')
        rows, columns = np.nonzero(found)
        distances = [np.min(np.hypot(line[:, 0] - x, line[:, 1] - y)) for y, x in list(zip(rows, columns))[::7]]
        self.assertLess(np.quantile(distances, 0.99), 5, f'{name}: pixels of the path are where there is no path')

    @staticmethod
    def between(places):
        """The places of a line on the canvas, and more of them on the way from each to the next."""
        line = np.array([(p['x'], p['y']) for p in places if p])
        return np.concatenate([line[:-1] + share * (line[1:] - line[:-1]) for share in np.linspace(0, 1, 200)])

    def show(self, *layers):
        """Shows these alone."""
        for layer in LAYERS:
            if self.browser.js('return document.getElementById(arguments[0]).checked', f'covis-show-{layer}') != (layer in layers):
                self.browser.click(f'covis-show-{layer}')

    def path(self):
        return self.browser.js('return covis.page.model.sortedPath().map(p => p.t)')

    def test_1_the_live_page_becomes_the_finished_run(self):
        browser = self.browser
        self.assertEqual(browser.text('covis-mode'), 'finished run')
        self.assertEqual(browser.js('return covis.model.frames.length'), 60)
        self.assertIn('60 frames', browser.text('covis-counts'))
        browser.click('covis-fit')
        self.check_line('live', PATH, self.path())

    def test_2_a_click_on_a_key_frame_shows_its_image_and_observations(self):
        browser = self.browser
        browser.click('covis-fit')
        key_frame = browser.js('const all = [...covis.model.keyFrames.values()], k = all[all.length - 1]; return {id: k.id, ...covis.project(k.t)}')
        browser.click_at('covis-canvas', key_frame['x'], key_frame['y'])
        browser.until('return document.getElementById("covis-picked-text").textContent.includes(" points")')
        self.assertEqual(browser.text('covis-picked-title'), f'Key frame {key_frame["id"]}')
        self.assertNotIn('No image', browser.text('covis-picked-text'))
        status = browser.driver.execute_async_script('const done = arguments[0]; fetch("key_frame/%d").then(r => done(r.status))' % key_frame['id'])
        self.assertEqual(status, 200)
        self.pixels('picked')

    def test_3_a_click_on_a_point_shows_who_observes_it(self):
        browser = self.browser
        browser.click('covis-fit')
        # One that no key frame and no other point is near.
        point = browser.js('''
          for (const p of covis.model.points.values()) {
            const at = covis.project(p.t);
            if (at && at.x > 20 && at.y > 20 && at.x < 700 && at.y < 500 && covis.page.scene.pick(at.x, at.y)?.point === p.id) return {id: p.id, ...at};
          }''')
        browser.click_at('covis-canvas', point['x'], point['y'])
        browser.until('return document.getElementById("covis-picked-text").textContent.includes("key frames")')
        self.assertEqual(browser.text('covis-picked-title'), f'Point {point["id"]}')
        browser.until('return document.querySelectorAll("#covis-picked-text button").length > 0')

    def test_4_playback_goes_through_the_frames(self):
        browser = self.browser
        browser.js('covis.page.player.seek(20)')
        browser.settle()
        self.assertIn('frame 20', browser.text('covis-clock'))
        self.assertLess(browser.js('return covis.page.scene.layers.points.drawn'), browser.js('return covis.model.points.size'))
        browser.click('covis-play')
        browser.until('return covis.page.player.at > 30')
        browser.until('return !covis.page.player.playing')
        self.assertIn('frame 59', browser.text('covis-clock'))

    def test_5_following_keeps_the_camera_in_the_middle(self):
        browser = self.browser
        if not browser.js('return document.getElementById("covis-follow").checked'):
            browser.click('covis-follow')
        for position in (15, 45):
            browser.js('covis.page.player.seek(arguments[0])', position)
            browser.settle()
            place = browser.js('return covis.project(covis.model.poseOf(covis.page.player.row).t)')
            size = browser.js('const c = document.getElementById("covis-canvas"); return [c.clientWidth, c.clientHeight]')
            self.assertAlmostEqual(place['x'], size[0] / 2, delta=3)
            self.assertAlmostEqual(place['y'], size[1] / 2, delta=3)
        browser.click('covis-follow')
        before = browser.js('return covis.page.scene.camera.position.toArray()')
        browser.js('covis.page.player.seek(Infinity)')
        browser.settle()
        self.assertEqual(browser.js('return covis.page.scene.camera.position.toArray()'), before)

    def test_6_charts_zoom_and_go_to_a_frame(self):
        browser = self.browser
        browser.js('''document.getElementById("covis-inliers").dispatchEvent(
          new WheelEvent("wheel", {deltaY: -100, bubbles: true, clientX: 300, clientY: 740}))''')
        shown = browser.js('return covis.page.range.last - covis.page.range.first')
        self.assertLess(shown, 59)
        browser.js('covis.page.range.reset()')
        browser.click_at('covis-inliers', 300, 50)
        self.assertNotIn('frame 59', browser.text('covis-clock'))
        browser.js('covis.page.player.seek(Infinity)')

    def test_7_layers_can_be_hidden(self):
        browser = self.browser
        browser.click('covis-fit')
        for layer in ('path', 'keyFrames', 'points', 'current'):
            browser.click(f'covis-show-{layer}')
        image, (left, top, right, bottom) = self.pixels('hidden')
        self.assertFalse((np.abs(image - PATH).max(axis=2) <= 3)[top:bottom, left:right].any())
        # What is hidden is not picked: first of nothing, then of the points alone.
        pick = 'const [k] = covis.model.keyFrames.values(), {x, y} = covis.project(k.t); return covis.page.scene.pick(x, y)?.keyFrame'
        self.assertIsNone(browser.js(pick))
        browser.click('covis-show-points')
        self.assertIsNone(browser.js(pick))
        browser.click('covis-show-keyFrames')
        self.assertIsNotNone(browser.js(pick))
        for layer in ('path', 'current'):
            browser.click(f'covis-show-{layer}')
        self.assertEqual(browser.problems(), [])

    def test_8_dragging_turns_the_view(self):
        browser = self.browser
        browser.click('covis-fit')
        place = 'const {camera, controls} = covis.page.scene; return [camera.position.toArray(), controls.target.toArray()]'
        before, middle = (np.array(v) for v in browser.js(place))
        browser.drag('covis-canvas', (120, -40))
        after, still = (np.array(v) for v in browser.js(place))
        np.testing.assert_allclose(still, middle)
        self.assertAlmostEqual(np.linalg.norm(after - middle), np.linalg.norm(before - middle), places=5)
        self.assertGreater(np.linalg.norm(after - before), 0.2 * np.linalg.norm(before - middle))
        self.check_line('turned', PATH, self.path())
        browser.click('covis-fit')

    def test_9_the_result_and_the_map_are_served_alone(self):
        browser = self.browser
        with Served([self.covis, 'view', self.folder / 'out', '--port', '0']) as served:
            browser.open(served.url)
            self.check_line('result', PATH, self.path())
            self.assertEqual(browser.js('return covis.model.frames.length'), 60)
        browser.until('return document.getElementById("covis-mode").textContent === "the command has ended"')
        with Served([self.covis, 'view', self.folder / 'desk.m', '--port', '0']) as served:
            browser.open(served.url)
            self.assertEqual(browser.text('covis-mode'), 'saved map')
            self.check_line('map', PATH, browser.js('return covis.model.sortedKeyFrames().map(k => k.t)'))

    def test_a_the_report_holds_the_same_view(self):
        browser = self.browser
        browser.driver.get('about:blank')
        browser.problems()  # drops those of the page before, which looked for a command that had ended
        browser.open((self.folder / 'out/report.html').as_uri())
        browser.js('document.getElementById("covis-viewer").scrollIntoView()')
        self.check_line('report', PATH, self.path())
        top = browser.js('return window.scrollY')
        browser.scroll('covis-inliers', -100)
        self.assertLess(browser.js('return covis.page.range.last - covis.page.range.first'), 59)
        self.assertEqual(browser.js('return window.scrollY'), top)
        self.assertEqual(browser.problems(), [])

    def test_b_a_loop_shows_the_path_before_and_after(self):
        browser = self.browser
        (self.folder / 'made').mkdir()
        (self.folder / 'made/scene.bin').write_bytes(made_scene(60, 3000, loop=True))
        with Served([self.covis, 'view', self.folder / 'made', '--port', '0']) as served:
            browser.open(served.url)
            for layer in ('points', 'path', 'keyFrames'):
                browser.click(f'covis-show-{layer}')
            browser.js('document.querySelector("[data-loop]").click()')
            browser.settle()
            self.check_line('loop', BEFORE, browser.js('return covis.model.loops[0].before.map(p => p.t)'))
            browser.js('document.querySelector("[data-loop]").click()')
            browser.settle()
            image, (left, top, right, bottom) = self.pixels('no_loop')
            self.assertLess((np.abs(image - BEFORE).max(axis=2) <= 3)[top:bottom, left:right].sum(), 20)

    def test_c_the_page_of_a_run_that_goes_on_is_live(self):
        browser = self.browser
        # Three minutes long, of which this case sees the first seconds: the command is ended with the block.
        slowed(self.folder / 'desk', self.folder / 'slow', 90)
        with Served([self.covis, 'run', self.folder / 'slow', '--out', self.folder / 'slow_out', '--realtime', '--view=0']) as served:
            browser.driver.get(served.url)
            browser.until(KEYPOINTS_ARE_DRAWN)
            frames = browser.js('return covis.model.frames.length')
            self.assertEqual(browser.text('covis-mode'), 'live')
            self.assertEqual(browser.text('covis-state'), 'tracking')
            self.assertRegex(browser.text('covis-image-text'), r'^frame \d+: [1-9]\d* tracked, \d+ new, \d+ lost$')
            self.pixels('image')
            browser.until(f'return covis.model.frames.length > {frames}')
            self.assertLess(frames, 60)
            # The processor draws here, so the page wants a message now and then only.
            self.assertEqual(browser.js('return covis.page.source.interval'), 500)

    def test_d_submaps_have_their_colours_and_edges_their_threshold(self):
        browser = self.browser
        (self.folder / 'two').mkdir()
        (self.folder / 'two/scene.bin').write_bytes(made_scene(60, 3000, loop=True, submaps=2))
        with Served([self.covis, 'view', self.folder / 'two', '--port', '0']) as served:
            browser.open(served.url)
            self.assertEqual(browser.text('covis-submaps'), 'Submapssubmap 0submap 1')
            self.show('path')
            path = browser.js('return covis.model.sortedPath()')
            for submap, colour in enumerate((PATH, SECOND_SUBMAP)):
                self.check_line(f'submap_{submap}', colour, [p['t'] for p in path if p['submap'] == submap])
            self.show('loops')
            self.check_line('loop_edge', LOOP, browser.js('''
              const {edges, keyFrames} = covis.model, edge = [...edges.values()].find(e => e.loop);
              return [edge.a, edge.b].map(id => keyFrames.get(id).t)'''))
            self.show('points')
            browser.choose('covis-colour', 'submap')
            image, _ = self.pixels('points_by_submap')
            for colour in (PATH, SECOND_SUBMAP):
                self.assertGreater((np.abs(image - colour).max(axis=2) <= 3).sum(), 1000)
            self.show('covisibility')
            browser.choose('covis-covisibility', '0')
            none, _ = self.pixels('no_edges')
            browser.choose('covis-covisibility', '100')
            strong = (self.pixels('strong_edges')[0] != none).any(axis=2).sum()
            browser.choose('covis-covisibility', '15')
            self.assertGreater(strong, 100)
            self.assertGreater((self.pixels('all_edges')[0] != none).any(axis=2).sum(), 1.2 * strong)

    def test_e_a_lost_camera_is_red_where_it_was_last(self):
        browser = self.browser
        (self.folder / 'lost').mkdir()
        (self.folder / 'lost/scene.bin').write_bytes(made_scene(60, 3000, lost=[*range(10), *range(100, 120)]))
        with Served([self.covis, 'view', self.folder / 'lost', '--port', '0']) as served:
            browser.open(served.url)
            browser.problems()  # drops those of the page before, whose command has ended
            self.show('current')
            for position, last, colour in ((200, 200, TRACKED), (119, 99, LOST), (99, 99, TRACKED)):
                browser.js('covis.page.player.seek(arguments[0])', position)
                image, (left, top, _, _) = self.pixels(f'camera_{position}')
                place = browser.js('return covis.project(covis.model.poseOf(covis.model.frames[arguments[0]]).t)', last)
                rows, columns = np.nonzero(np.abs(image - colour).max(axis=2) <= 3)
                near = np.hypot(columns - left - place['x'], rows - top - place['y']) < 60
                self.assertGreater(near.sum(), 20, position)
            # Nothing is known of where it was before the first pose.
            browser.js('covis.page.player.seek(5)')
            browser.settle()
            self.assertEqual(browser.js('return covis.page.scene.layers.current.frames.length'), 0)
            self.assertEqual(browser.problems(), [])

    def pick(self, key_frame):
        """Picks it; whether it has an image, and the size of its picture."""
        self.browser.driver.execute_async_script('covis.page.selection.choose({keyFrame: arguments[0]}).then(arguments[1])', key_frame)
        self.browser.until('return document.getElementById("covis-picked").dataset.picture === "yes" || '
                           'document.getElementById("covis-picked-text").textContent.includes("No image")')
        return self.browser.js('const c = document.getElementById("covis-picked"); return [c.dataset.picture === "yes", c.width, c.height]')

    def test_f_images_of_any_format_are_shown(self):
        browser = self.browser
        kept = self.folder / 'kept.m.images'
        kept.mkdir()
        shutil.copy(self.folder / 'desk.m', self.folder / 'kept.m')
        grey = Image.open(sorted((self.folder / 'desk/rgb').iterdir())[0]).convert('L')
        for name in ('000000.pgm', '000001.tif'):
            grey.save(kept / name)
        (kept / '000002.jpg').write_bytes(b'\xff\xd8 no image')
        with Served([self.covis, 'view', self.folder / 'kept.m', '--port', '0']) as served:
            browser.open(served.url)
            browser.problems()  # drops those of the page before, whose command has ended
            self.assertEqual(browser.js('return [0, 1, 2].map(id => covis.model.keyFrames.has(id))'), [True] * 3)
            for key_frame, there in ((0, True), (1, True), (2, False)):
                self.assertEqual(self.pick(key_frame)[0], there, key_frame)
            self.assertEqual(browser.problems(), [])

    def test_g_key_frames_are_shown_by_the_camera_that_made_them(self):
        browser = self.browser
        (self.folder / 'cameras').mkdir()
        scene = made_scene(60, 3000, second_camera=(1758, 1758, 640, 360, 1280, 720))
        (self.folder / 'cameras/scene.bin').write_bytes(scene)
        with Served([self.covis, 'view', self.folder / 'cameras', '--port', '0']) as served:
            browser.open(served.url)
            for key_frame, shape in ((3, 640 / 480), (50, 1280 / 720)):
                _, width, height = self.pick(key_frame)
                self.assertAlmostEqual(width / height, shape, delta=0.02)
                # Of a frustum the fifth and sixth segment are the upper and the right side of the image.
                sides = browser.js('''
                  const {array} = covis.page.scene.layers.keyFrames.object.geometry.attributes.position;
                  return [4, 5].map(segment => {
                    const from = 48 * arguments[0] + 6 * segment, [x, y, z, u, v, w] = array.slice(from, from + 6);
                    return Math.hypot(u - x, v - y, w - z);
                  })''', key_frame)
                self.assertAlmostEqual(sides[0] / sides[1], shape, delta=0.01)


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('covis')
    parser.add_argument('--pictures', help='keep the pictures here')
    arguments, rest = parser.parse_known_args()
    ViewerTest.covis, ViewerTest.pictures = arguments.covis, arguments.pictures
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
