BEGIN TRANSACTION;
CREATE TABLE archive_takes (
	archive INTEGER NOT NULL, 
	name TEXT NOT NULL, 
	take VARCHAR(64), 
	status VARCHAR(16) NOT NULL, 
	reason TEXT NOT NULL, 
	PRIMARY KEY (archive, name), 
	FOREIGN KEY(archive) REFERENCES archives (id)
);
INSERT INTO "archive_takes" VALUES(1,'walk.c3d','a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1','done','');
CREATE TABLE archives (
	id INTEGER NOT NULL, 
	folder TEXT NOT NULL, 
	settings VARCHAR(64) NOT NULL, 
	content JSON NOT NULL, 
	begun DATETIME NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT one_archive_per_settings UNIQUE (folder, settings)
);
INSERT INTO "archives" VALUES(1,'/archive','5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e','{}','2026-01-02 03:04:05.000000');
CREATE TABLE claims (
	take VARCHAR(64) NOT NULL, 
	seat TEXT NOT NULL, 
	review INTEGER NOT NULL, 
	operator TEXT NOT NULL, 
	session VARCHAR(32) NOT NULL, 
	since DATETIME NOT NULL, 
	until DATETIME NOT NULL, 
	PRIMARY KEY (take, seat), 
	FOREIGN KEY(take) REFERENCES takes (sha256), 
	FOREIGN KEY(review) REFERENCES reviews (id)
);
INSERT INTO "claims" VALUES('a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1','review',1,'anna','5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e','2026-01-02 03:04:05.000000','2026-01-02 03:05:35.000000');
CREATE TABLE exercises (
	id INTEGER NOT NULL, 
	take VARCHAR(64) NOT NULL, 
	made DATETIME NOT NULL, 
	content JSON NOT NULL, 
	PRIMARY KEY (id), 
	FOREIGN KEY(take) REFERENCES takes (sha256)
);
INSERT INTO "exercises" VALUES(1,'a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1','2026-11-22 11:00:00.000000','{"take":"a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1","level":2,"seed":3,"kinds":["peak"],"amplitude_mm":25.0,"hidden":true,"answers":[{"marker":"A","kind":"peak","amplitude":25.0,"axes":["x"],"partner":null,"start":50,"stop":52,"values":[[1.0,2.0,3.0],[1.5,null,3.0]]}],"neutral":[["B",10,20]]}');
CREATE TABLE grades (
	id INTEGER NOT NULL, 
	exercise INTEGER NOT NULL, 
	trainee TEXT NOT NULL, 
	at DATETIME NOT NULL, 
	result JSON NOT NULL, 
	PRIMARY KEY (id), 
	FOREIGN KEY(exercise) REFERENCES exercises (id)
);
INSERT INTO "grades" VALUES(1,1,'anna','2026-11-22 11:00:00.000000','{"version":1,"level":2,"rmse_before_mm":20.0,"rmse_after_mm":1.5,"worse":false,"seconds_per_finding":8.0,"kinds":{"peak":{"true":1,"found":1,"right":1,"called":2,"wrong":1}}}');
CREATE TABLE journal (
	review INTEGER NOT NULL, 
	seq INTEGER NOT NULL, 
	action VARCHAR(8) NOT NULL, 
	command JSON, 
	operator TEXT NOT NULL, 
	at DATETIME NOT NULL, token VARCHAR(32), 
	PRIMARY KEY (review, seq), 
	FOREIGN KEY(review) REFERENCES reviews (id)
);
INSERT INTO "journal" VALUES(1,1,'do','{"command":"accept","findings":[{"id":"452bed7fde24","marker":"A","start":40,"stop":60,"kind":"gap","score":1.0,"axes":["x","y","z"],"amplitude":null,"detector":"gaps","strength":1.0}],"method":"savgol","parameters":{"mode":"ends","order":3,"robust":true,"window":0.25}}','anna','2026-11-22 10:28:17.023226',NULL);
INSERT INTO "journal" VALUES(1,2,'do','{"command":"reject","findings":[{"id":"0ef627d23c91","marker":"A","start":10,"stop":13,"kind":"peak","score":0.9,"axes":["z"],"amplitude":31.25,"detector":"published","strength":2.5},{"id":"efb6f06c1f12","marker":"A","start":20,"stop":23,"kind":"peak","score":0.9,"axes":["z"],"amplitude":31.25,"detector":"published","strength":2.5}]}','anna','2026-11-22 10:28:17.045613',NULL);
INSERT INTO "journal" VALUES(1,3,'do','{"command":"defer","findings":[{"id":"f15dac2929eb","marker":"B","start":100,"stop":110,"kind":"step","score":0.7,"axes":["x","y","z"],"amplitude":12.0,"detector":"operator","strength":1.0,"partner":"A","group":"g1"}]}','anna','2026-11-22 10:28:17.061317',NULL);
INSERT INTO "journal" VALUES(1,4,'do','{"command":"choose","findings":[{"id":"f15dac2929eb","marker":"B","start":100,"stop":110,"kind":"step","score":0.7,"axes":["x","y","z"],"amplitude":12.0,"detector":"operator","strength":1.0,"partner":"A","group":"g1"}],"method":"rigid","parameters":{"neighbours":4}}','anna','2026-11-22 10:28:17.073284',NULL);
INSERT INTO "journal" VALUES(1,5,'do','{"command":"reclassify","findings":[{"id":"f15dac2929eb","marker":"B","start":100,"stop":110,"kind":"step","score":0.7,"axes":["x","y","z"],"amplitude":12.0,"detector":"operator","strength":1.0,"partner":"A","group":"g1"}],"kind":"slow"}','anna','2026-11-22 10:28:17.130237',NULL);
INSERT INTO "journal" VALUES(1,6,'do','{"command":"move-edges","findings":[{"id":"f15dac2929eb","marker":"B","start":100,"stop":110,"kind":"step","score":0.7,"axes":["x","y","z"],"amplitude":12.0,"detector":"operator","strength":1.0,"partner":"A","group":"g1"}],"span":[98,112]}','anna','2026-11-22 10:28:17.150705',NULL);
INSERT INTO "journal" VALUES(1,7,'do','{"command":"annotate","findings":[{"id":"f15dac2929eb","marker":"B","start":100,"stop":110,"kind":"step","score":0.7,"axes":["x","y","z"],"amplitude":12.0,"detector":"operator","strength":1.0,"partner":"A","group":"g1"}],"note":"elbow \u00e4"}','anna','2026-11-22 10:28:17.191117',NULL);
INSERT INTO "journal" VALUES(1,8,'do','{"command":"add","findings":[{"id":"b4c78cb6925d","marker":"A","start":150,"stop":160,"kind":"noise","score":0.4,"axes":["x","y","z"],"amplitude":null,"detector":"operator","strength":1.0}]}','anna','2026-11-22 10:28:17.207336',NULL);
INSERT INTO "journal" VALUES(1,9,'do','{"command":"split","findings":[{"id":"b4c78cb6925d","marker":"A","start":150,"stop":160,"kind":"noise","score":0.4,"axes":["x","y","z"],"amplitude":null,"detector":"operator","strength":1.0}],"at":155}','anna','2026-11-22 10:28:17.262934',NULL);
INSERT INTO "journal" VALUES(1,10,'do','{"command":"merge","findings":[{"id":"c5477540875c","marker":"A","start":150,"stop":155,"kind":"noise","score":0.4,"axes":["x","y","z"],"amplitude":null,"detector":"operator","strength":1.0},{"id":"e6b938efea26","marker":"A","start":155,"stop":160,"kind":"noise","score":0.4,"axes":["x","y","z"],"amplitude":null,"detector":"operator","strength":1.0}]}','anna','2026-11-22 10:28:17.273662',NULL);
INSERT INTO "journal" VALUES(1,11,'do','{"command":"reopen","findings":[{"id":"452bed7fde24","marker":"A","start":40,"stop":60,"kind":"gap","score":1.0,"axes":["x","y","z"],"amplitude":null,"detector":"gaps","strength":1.0}]}','anna','2026-11-22 10:28:17.285646',NULL);
INSERT INTO "journal" VALUES(1,12,'do','{"command":"remove","findings":[{"id":"b4c78cb6925d","marker":"A","start":150,"stop":160,"kind":"noise","score":0.4,"axes":["x","y","z"],"amplitude":null,"detector":"operator","strength":1.0}]}','anna','2026-11-22 10:28:17.293585',NULL);
INSERT INTO "journal" VALUES(1,13,'undo',NULL,'anna','2026-11-22 10:28:17.297210',NULL);
INSERT INTO "journal" VALUES(1,14,'undo',NULL,'anna','2026-11-22 10:28:17.308082',NULL);
INSERT INTO "journal" VALUES(1,15,'redo',NULL,'anna','2026-11-22 10:28:17.313740','7e7e7e7e7e7e7e7e7e7e7e7e7e7e7e7e');
INSERT INTO "journal" VALUES(1,16,'undo',NULL,'anna','2026-11-22 10:28:17.323155','7e7e7e7e7e7e7e7e7e7e7e7e7e7e7e7e');
CREATE TABLE markermend_schema (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT markermend_schema_pkc PRIMARY KEY (version_num)
);
INSERT INTO "markermend_schema" VALUES('0004');
CREATE TABLE recipes (
	name TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	content JSON NOT NULL, 
	author TEXT NOT NULL, 
	at DATETIME NOT NULL, 
	PRIMARY KEY (name, version)
);
INSERT INTO "recipes" VALUES('gait',1,'{"schema":"markermend/recipe","version":1,"detector":"published","parameters":{},"kinds":["gap","peak"],"sensitivity":{"peak":2.0},"repair":{"gap":{"method":"auto","parameters":{},"most_mm":5.0,"most_s":0.5}}}','anna','2026-01-02 03:04:05.000000');
CREATE TABLE reviews (
	id INTEGER NOT NULL, 
	take VARCHAR(64) NOT NULL, 
	operator TEXT NOT NULL, 
	purpose TEXT NOT NULL, 
	status VARCHAR(16) NOT NULL, 
	created DATETIME NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT one_review_per_purpose UNIQUE (take, operator, purpose), 
	FOREIGN KEY(take) REFERENCES takes (sha256)
);
INSERT INTO "reviews" VALUES(1,'a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1','anna','review','open','2026-11-22 10:28:16.904068');
CREATE TABLE scans (
	take VARCHAR(64) NOT NULL, 
	settings VARCHAR(64) NOT NULL, 
	at DATETIME NOT NULL, 
	summary JSON NOT NULL, 
	findings JSON NOT NULL, 
	repaired JSON, 
	PRIMARY KEY (take, settings)
);
INSERT INTO "scans" VALUES('a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1','5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e','2026-01-02 03:04:05.000000','{"damage":1.5,"duration_s":2.0,"n_frames":200,"rate":100.0,"n_markers":2,"markers":["A","B"],"by":{"A":{"gap":[1,1.5]}}}','{"version":1,"rate":100.0,"n_frames":200,"findings":[],"warnings":[]}',NULL);
CREATE TABLE second_reviews (
	id INTEGER NOT NULL, 
	take VARCHAR(64) NOT NULL, 
	asked_by TEXT NOT NULL, 
	asked_of TEXT, 
	blinded BOOLEAN NOT NULL, 
	note TEXT NOT NULL, 
	at DATETIME NOT NULL, 
	ended DATETIME, 
	ended_by TEXT, 
	review INTEGER, 
	PRIMARY KEY (id), 
	FOREIGN KEY(take) REFERENCES takes (sha256), 
	FOREIGN KEY(review) REFERENCES reviews (id)
);
INSERT INTO "second_reviews" VALUES(1,'a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1','anna',NULL,1,'before the paper','2026-01-02 03:04:05.000000',NULL,NULL,NULL);
CREATE TABLE takes (
	sha256 VARCHAR(64) NOT NULL, 
	name TEXT NOT NULL, 
	path TEXT, 
	n_frames INTEGER NOT NULL, 
	rate FLOAT NOT NULL, 
	given_units VARCHAR(8), 
	given_rate FLOAT, 
	first_seen DATETIME NOT NULL, 
	last_seen DATETIME NOT NULL, 
	PRIMARY KEY (sha256)
);
INSERT INTO "takes" VALUES('a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1a1','walk.c3d','/takes/walk.c3d',200,100.0,'m',NULL,'2026-11-22 10:28:16.751121','2026-11-22 10:28:16.961031');
CREATE INDEX ix_takes_path ON takes (path);
CREATE INDEX ix_exercises_take ON exercises (take);
CREATE INDEX ix_grades_trainee ON grades (trainee);
CREATE INDEX ix_claims_review ON claims (review);
CREATE INDEX ix_second_reviews_take ON second_reviews (take);
COMMIT;
