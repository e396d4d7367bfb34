"""The survey for the project on a phone: on the virtual car, reloaded in its midst, saved."""

from __future__ import annotations

import zipfile

import pytest
from playwright.sync_api import expect

from mikas.survey import read_survey

from .site_rig import site_tab
from .test_site_phone import ANDROID, SMALL, UPRIGHT

pytestmark = pytest.mark.realtime


@pytest.fixture
def phone(chromium, site):
    context = chromium.new_context(
        viewport=UPRIGHT, has_touch=True, is_mobile=True, user_agent=ANDROID, locale="ru-RU"
    )
    with context, site_tab(context, site.url) as tab:
        yield tab.open("connection/survey")


def test_a_survey_on_a_phone_goes_on_after_a_reload_and_gives_its_file(phone, tmp_path):
    phone.says("Что можно?")
    assert phone.page.evaluate(SMALL) == []
    phone.page.get_by_text("Двигатель здесь можно пустить").tap()
    phone.button("Попробовать на виртуальном автомобиле").tap()
    expect(phone.find(".todo")).to_have_text("Зажигание включено, двигатель заглушен")
    expect(phone.find("#screen")).to_contain_text("коды 00–FF")
    phone.again()
    phone.says("Прервано. Измеренное сохранено.")
    expect(phone.find(".answers .found")).not_to_have_count(0)
    assert phone.page.evaluate(SMALL) == []
    phone.button("Сохранить файл").tap()
    phone.says("Сохранено: virtual-survey.zip")
    with phone.page.expect_download() as saving:
        phone.find("#screen a:has-text('Скачать')").tap()
    file = tmp_path / "got.zip"
    saving.value.save_as(file)
    assert zipfile.ZipFile(file).testzip() is None
    kept = read_survey(file)
    assert (kept.measured["engine"], kept.measured["passports_consent"]) == (False, False)
    assert "unknown" in kept.measured["done"]
