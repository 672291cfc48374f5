# SPDX-License-Identifier: BSD-3-Clause
"""Words and short talk of nine languages that must move nothing; none of them is trained on.

`near` comes near to a command in that language's sounds, `words` are anatomy, instruments and what
is said in a theatre. Words for training and for choosing thresholds are in
voice_assist.training.data.foreign_words; a test keeps the two apart.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Spoken:
    """What is said in one language."""

    voice: str  # of espeak-ng
    styles: tuple[str, ...]  # of Kokoro; none where all of the language are kept for others
    diphones: tuple[str, ...]  # MBROLA's voices of espeak-ng, of a person each
    near: str  # separated by "|"
    words: str
    talk: str


LANGUAGES = {
    "German": Spoken(
        "de",
        (),
        ("mb-de4",),
        "Pulmo|Tanz|Tennis|Tänze|Tenne|Riese|Police|Puls|Pullmann|Dens|Relief|Pollmer|"
        "Tennisarm|Krise",
        "Zange|Pinzette|Schere|Leber|Milz|Tupfer|Klemme|Sehne|Nerv|Zwerchfell|Schlauch|Naht",
        "bitte die Schere|der Puls ist normal|wo ist die Klemme|die Spannung ist zu hoch",
    ),
    "French": Spoken(
        "fr-fr",
        ("ff_siwis",),
        ("mb-fr1",),
        "poumon|relise|tension|tenseur|dense|police|réalise|poulets|poule morte|pour moi|"
        "reprise|lisse|danse|valise",
        "ciseaux|pince|foie|rate|aiguille|scalpel|veine|nerf|suture|artère|compresse|écarteur",
        "donnez-moi les ciseaux|la tension est trop haute|où est la pince|on peut fermer",
    ),
    "Spanish": Spoken(
        "es",
        ("ef_dora",),
        ("mb-es1",),
        "tenso|pulmón|pulmones|tensas|realice|relieve|pulsos|pulir|por más|denso|pules|"
        "tenis|feliz|tensión",
        "tijeras|pinza|hígado|bazo|aguja|bisturí|vena|nervio|sutura|arteria|gasa|separador",
        "deme las tijeras|la tensión está muy alta|dónde está la pinza|ya podemos cerrar",
    ),
    "Italian": Spoken(
        "it",
        (),
        (),
        "tenso|polmone|polmoni|tensa|rilascia|realizza|polso|pulisci|tensione|denso|"
        "pulmino|tende|riluce|elisi",
        "forbici|pinza|fegato|milza|ago|bisturi|vena|nervo|sutura|arteria|garza|divaricatore",
        "mi dia le forbici|la tensione è troppo alta|dove è la pinza|possiamo chiudere",
    ),
    "Portuguese": Spoken(
        "pt-br",
        ("pf_dora",),
        (),
        "tenso|pulmão|pulmões|tensa|relise|realize|pulso|polícia|tensão|denso|polir|alise|"
        "raízes|por mais",
        "tesoura|pinça|fígado|baço|agulha|bisturi|veia|nervo|sutura|artéria|gaze|afastador",
        "me dê a tesoura|a pressão está muito alta|onde está a pinça|podemos fechar",
    ),
    "Dutch": Spoken(
        "nl",
        (),
        ("mb-nl2",),
        "tensie|dans|tent|tennis|relies|reliëf|pols|politie|pool meer|pulp|tenzij|dents|"
        "verlies|polsen",
        "schaar|pincet|lever|milt|naald|klem|pees|zenuw|slang|slagader|gaasje|hechting",
        "geef mij de schaar|de tensie is te hoog|waar is de klem|we kunnen sluiten",
    ),
    "Japanese": Spoken(
        "ja",
        ("jm_kumo",),
        (),
        "てんじ|てんせ|てんし|でんす|てんさい|プルメ|プルモ|ぷるも|プレス|リリー|りいし|れいす|ポリス|テニス",
        "はさみ|かんぞう|ひぞう|はり|けっかん|しんけい|ガーゼ|どうみゃく|はいえん|ピンセット|じんぞう|メス",
        "はさみを ください|けつあつが たかいです|ピンセットは どこですか|もう とじます",
    ),
    "Hindi": Spoken(
        "hi",
        (),
        (),
        "पुलिस|तनाव|टेनिस|दंत|तेज़|पुल मरम्मत|फूल माला|पल्स|रिलीफ|रईस|तीस|दिन से|पुल से|तन से",
        "कैंची|चिमटी|जिगर|तिल्ली|सुई|नस|धमनी|फेफड़ा|गुर्दा|आंत|टांका|रूई",
        "मुझे कैंची दो|रक्तचाप बहुत ज़्यादा है|चिमटी कहाँ है|अब बंद कर सकते हैं",
    ),
    "Chinese": Spoken(
        "cmn-latn-pinyin",
        (),
        (),
        "teng2 si3|tian1 si1|dian4 si1|pu1 mo1|po4 men2|pu2 lei2 si1|li4 shi3|ri4 li4|"
        "lei4 si3|tan4 si1|bu4 lei4|pei2 mo4|deng3 si3|tian1 se4",
        "jian3 dao1|nie4 zi5|gan1 zang4|pi2 zang4|zhen1|xue4 guan3|shen2 jing1|fei4 bu4|"
        "dong4 mai4|sha1 bu4|shen4 zang4|feng2 he2",
        "qing3 gei3 wo3 jian3 dao1|xue4 ya1 tai4 gao1|nie4 zi5 zai4 na3 li3|ke3 yi3 guan1 bi4 le5",
    ),
}

# Of the requirement: voice of espeak-ng and word. Each was a motion in nearly every voice.
NAMED = (
    *(("nl", "tensie"), ("fr-fr", "poumon"), ("fr-fr", "relise"), ("de", "Pulmo")),
    *(("es", "tenso"), ("it", "tenso")),
)
