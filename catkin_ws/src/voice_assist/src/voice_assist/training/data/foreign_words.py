# SPDX-License-Identifier: BSD-3-Clause
"""Words of nine languages that are no command, by the voice of espeak-ng that says them.

Those that come near to a command in their language's sounds stand first. How a language says the
command itself, such as Japanese "ririisu", is in no list. Words that measure are others, which
bench.voice.material.foreign_words holds.
"""

WORDS = {
    "de": """
Pulmonal|Polmo|Pulmor|Pullmo|Pulmos|Bulle|Pulle|Pullis|Pulli|Pullmeer|Pole|Polen|Polizei|Palais
Tendenz|Tenside|Tension|Tensor|Dänen|Denis|Denso|Tanzt|Tenor|Tempel|Tenz|Dentes|Zens|Sense
Relais|Relation|Riesen|Wiese|Analyse|Kreis|Reliquie|Reliest|Lies|Verlies|Paradies|Rollis
Terminus|Terminiert|Termin|Gehirn|Niere|Magen|Darm|Lunge|Skalpell|Hammer|Spritze|Kanüle|Haken
Gefäß|Muskel|Knochen|Blut|Wunde|Licht|Ziehen|mehr|weniger|loslassen|spannen|Faden|Handschuh
das Bild ist scharf|noch einen Faden bitte|alles in Ordnung""",
    "fr-fr": """
poumons|pulmonaire|poulmon|pommons|poulain|poule|poulpe|plumons|pull mort|pour mort|pas mort|palme
tente|tendon|tendance|tensions|intense|tends|danses|tiens|denses|tanse|tenez|sens
relis|relisez|relire|relit|église|élise|cerise|Denise|surprise|remise|reluise|reliure|relais
palace|Paulus|pouls|poulie|poulesse|pelisse|pull laisse|pousse|pou laisse|complice|paresse
terminé|terminez|rein|estomac|intestin|bistouri|seringue|muscle|sang|plaie|lumière|tirez
plus|moins|relâchez|tendez|fil|gants|encore un fil|l'image est nette|tout va bien""",
    "es": """
pulmonar|polmón|pulmo|pulmona|palomo|por amor|pólvora|pueblo|pulga|púlpito|puro amor|pulgar|plomo
tensar|tensor|tensos|densa|tienes|tienda|dientes|tensiones|intenso|extenso|tenis de mesa|senso|ten
reliza|relee|relees|raíz|raíces|realizo|deslice|elise|elige|aliso|paliza|relés|religión|relisa
pulí|pulsa|pulseras|palés|por eso|pues|pulis|pelis|poleas|por les|bolis|pollos
terminad|terminé|riñón|estómago|intestino|escalpelo|jeringa|músculo|sangre|herida|luz|tirar
más|menos|soltar|hilo|guantes|otro hilo por favor|la imagen está clara|todo bien""",
    "it": """
polmonare|pulmo|polmon|palmo|pulmini|per amore|bulmo|pulire|pollo|polvere|piumone|prugna
tensore|tensi|densa|densi|tenda|tenero|tendine|tensioni|intenso|senso|tendi|dente
rilassa|rilasso|rilisa|realizzi|relitto|rilascio|radice|rielise|relisi|risi|rilievo|Elisa|incisi
polsi|pulisce|pulì|pullis|polizia|pulsi|polis|pulce|pulite|pelle|pulless|bolle|palestra
terminale|rene|stomaco|intestino|scalpello|siringa|muscolo|sangue|ferita|luce|tirare
più|meno|lasciare|filo|guanti|ancora un filo|l'immagine è nitida|tutto bene""",
    "pt-br": """
pulmonar|pulmo|palmo|por amor|pulmona|pólvora|pulga|pomo|bulmo|plumão|porão|pumo|palmão
tensor|tensos|densa|densos|tenda|dentes|tensões|intenso|senso|tênis|denso alto
reluz|realiza|releia|relês|raiz|relíquia|relis|deslize|elise|analise|relevo|religa|paralise
pulsa|pulos|polis|pulse|pulei|poles|por lês|bules|pilés|pouls|pulmonares
termine|terminei|rim|estômago|intestino|escalpelo|seringa|músculo|sangue|ferida|luz|puxar
mais|menos|soltar|fio|luvas|outro fio por favor|a imagem está clara|tudo bem""",
    "nl": """
pulmo|pulmonaal|puur moor|poolmoor|pullmor|pol|polder|poel|poelmoer|pullen|pulmoor|palm|boelmoor
tensies|dansen|tenten|tenor|tenslotte|tent op|tentje|dennen|zens|tien|denk|intens
relaas|relatie|relais|realis|reliek|analyse|reis|vlies|kies|relis|rillies|riolies
poolles|pulles|poelles|palles|polis|pollen|pulls|polites|poelies|bolles|polies|pulsen|pullie
termijn|terminaal|nier|maag|darm|long|spuit|spier|bloed|wond|licht|trekken
meer|minder|loslaten|spannen|draad|handschoen|nog een draad|het beeld is scherp|alles goed""",
    "ja": """
てんすう|てんそ|てんしゅ|でんせ|でんせん|てんてん|てんせい|てんせん|てんず|てんすい|センス|テント|てんき|ダンス
プルマ|プリモ|ふるも|ブルモ|ぷるぷる|プール|プラモ|ぱるも|ポルモ|プロモ|こども|ぷるむ|ふるもん
りり|れりす|りれき|リレー|レース|りす|リースを|りりしい|ライス|りっす|リリク|れきし
プルス|プルレ|ぷられす|プラス|ブレス|ふれす|ぷれ|ポルス|パレス|フルレ
じん|い|ちょう|のう|ほね|きんにく|ち|きず|ひかり|ひっぱる|もっと|すこし|はなす|いと|てぶくろ
いとを もう いっぽん|がぞうは きれいです|だいじょうぶ です""",
    "hi": """
पुलमो|पल मोर|पूल मोड|बुल मोर|पलमो|पुल|मोर|फूल|पुल मर|पल भर|पुल मो|पालमो
तेनसा|दांत|तनसा|डेंस|तेन|टेंट|टैंक|तेंदुआ|देन से|तीन से|सेंस|टेंशन|दान से
रेलीस|रिलिस|रिश्ते|रेल इस|पुलिस रेल|रिया लीस|रीलिस|बीस|रिलीव|रेलवे|रसीला
पुलेस|पल्लस|पालिस|पोलिस|पूल से|पुलिन|बुलेस|पल लेस|फुल लेस|पुल्स
दिमाग|पेट|हड्डी|मांसपेशी|खून|घाव|रोशनी|खींचो|ज़्यादा|कम|छोड़ो|धागा|दस्ताने
एक और धागा दो|तस्वीर साफ है|सब ठीक है""",
    "cmn-latn-pinyin": """
teng2 se4|tan1 si1|tian2 si1|deng1 si1|dan1 si1|tian1 shi3|dian4 shi4|tian1 sai4|teng2 shi2
ten2 si1|ting1 shuo1|teng2
pu3 mo4|pao4 mo4|bu1 mo1|pu1 mou2|po2 mo4|pu4 mo2|hu1 mo1|pu2 mo4 er2|po1 lan4|bu4 mo4 er3|mo4|pu1
li3 li4 si1|rui4 li4 si1|li4 si1|ri4 li4 si1|yi1 li4 si1|lei2 si1|li4 lv4|re4 li4 si3|li3 si1
ru2 li4 shi4
pu3 lei2|bu4 lei2 si1|po4 lie4|pu1 lei4 si1|pu2 le4 si1|hu1 lei2|bo1 li2|pu4 lie4|bao1 lei3
po1 lei3 si1
shen4|wei4|chang2|nao3|gu3 tou2|ji1 rou4|xue4|shang1 kou3|deng1 guang1|la1|duo1|shao3|fang4 kai1
xian4
shou3 tao4|zai4 lai2 yi4 gen1 xian4|tu2 xiang4 hen3 qing1 chu3|yi1 qie4 zheng4 chang2""",
}
