# SPDX-License-Identifier: Apache-2.0
"""Drives the viewer in Debian's Chromium, without a display: for tests, measurements and the documentation's pictures."""
import pathlib
import re
import shutil
import subprocess
import tempfile
import threading
import time

OPTIONS = ['--headless=new', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic',
           '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync', '--disable-extensions',
           '--force-device-scale-factor=1', '--hide-scrollbars', '--disable-dev-shm-usage']
PATIENCE = 120  # seconds; a limit for what never comes, no measure


class Served:
    """A covis command that serves the viewer; ends with the block."""

    def __init__(self, command):
        self.process = subprocess.Popen([str(word) for word in command], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        self.lines = []
        self.ready = threading.Event()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        if not self.ready.wait(PATIENCE) or not self.url:
            raise RuntimeError('the viewer gave no address: ' + ''.join(self.lines))

    url = None

    def _read(self):
        for line in self.process.stderr:
            self.lines.append(line)
            found = re.search(r'http://\S+', line)
            if found and not self.url:
                self.url = found.group(0)
                self.ready.set()
        self.ready.set()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        try:
            self.process.wait(30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.reader.join()
        self.process.stderr.close()


class Browser:
    def __init__(self, width=1280, height=800):
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service
        self.profile = tempfile.mkdtemp(prefix='covis-chromium-')
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which('chromium')
        for option in OPTIONS + [f'--user-data-dir={self.profile}', f'--window-size={width},{height}']:
            options.add_argument(option)
        options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
        self.driver = webdriver.Chrome(service=Service(shutil.which('chromedriver')), options=options)
        self.driver.set_script_timeout(PATIENCE)
        self.resize(width, height)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.driver.quit()
        shutil.rmtree(self.profile, ignore_errors=True)

    def resize(self, width, height):
        # The window's size has its frame in it; the page's is what counts.
        self.driver.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': False})

    def open(self, url):
        """Opens the page and waits until it has drawn a map."""
        self.driver.get(url)
        self.until('return covis.model.keyFrames.size > 1')
        self.settle()

    def js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def until(self, condition, pause=0.05):
        end = time.monotonic() + PATIENCE
        while not self.js(condition):
            if time.monotonic() > end:
                raise TimeoutError(f'{condition}: it did not come true; the page says {self.problems()}')
            time.sleep(pause)

    def settle(self):
        """Waits until what was asked for is drawn: two frames of the browser."""
        self.driver.execute_async_script('const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done()))')

    def click(self, element):
        from selenium.webdriver.common.by import By
        self.driver.find_element(By.ID, element).click()
        self.settle()

    def click_at(self, element, x, y):
        """Clicks at a place of an element, from its left upper corner."""
        from selenium.webdriver.common.action_chains import ActionChains
        from selenium.webdriver.common.by import By
        target = self.driver.find_element(By.ID, element)
        size = target.rect
        ActionChains(self.driver).move_to_element_with_offset(target, round(x - size['width'] / 2), round(y - size['height'] / 2)).click().perform()
        self.settle()

    def drag(self, element, by):
        """Drags from the middle of an element."""
        from selenium.webdriver.common.action_chains import ActionChains
        from selenium.webdriver.common.by import By
        ActionChains(self.driver).click_and_hold(self.driver.find_element(By.ID, element)).move_by_offset(*by).release().perform()
        self.settle()

    def scroll(self, element, by):
        """Turns the wheel over the middle of an element; a negative `by` turns it away from the user."""
        from selenium.webdriver.common.action_chains import ActionChains
        from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
        from selenium.webdriver.common.by import By
        ActionChains(self.driver).scroll_from_origin(ScrollOrigin.from_element(self.driver.find_element(By.ID, element)), 0, by).perform()
        self.settle()

    def choose(self, element, value):
        from selenium.webdriver.common.by import By
        from selenium.webdriver.support.ui import Select
        Select(self.driver.find_element(By.ID, element)).select_by_value(value)
        self.settle()

    def text(self, element):
        return self.js('return document.getElementById(arguments[0]).textContent', element)

    def problems(self):
        """What the page logged as an error."""
        return [entry['message'] for entry in self.driver.get_log('browser') if entry['level'] == 'SEVERE']

    def screenshot(self, file):
        self.settle()
        self.driver.get_screenshot_as_file(str(file))
        return pathlib.Path(file)
