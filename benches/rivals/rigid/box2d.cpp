// Discs and rectangles in Box2D 2.4, for planar.py: c++ -O3 -march=native -shared -fPIC box2d.cpp -lbox2d.
#include <box2d/box2d.h>

#include <cstdio>
#include <vector>

struct Pile {
    b2World world;
    std::vector<b2Body *> bodies;
    explicit Pile(float gravity) : world(b2Vec2(0.0f, -gravity)) { world.SetAllowSleeping(false); }
};

extern "C" {

const char *version() {
    static char text[32];
    std::snprintf(text, sizeof text, "%d.%d.%d", b2_version.major, b2_version.minor, b2_version.revision);
    return text;
}

// Rows of bodies: x, y, angle, radius or half the width, 0 or half the height. Rows of lines: the ends of each.
void *build(int count, const double *rows, int lines, const double *ends, double gravity, double density, double friction) {
    Pile *pile = new Pile(static_cast<float>(gravity));
    b2BodyDef still;
    b2Body *ground = pile->world.CreateBody(&still);
    for (int k = 0; k < lines; k++) {
        const double *end = ends + 4 * k;
        b2EdgeShape edge;
        edge.SetTwoSided(b2Vec2(end[0], end[1]), b2Vec2(end[2], end[3]));
        b2FixtureDef fixture;
        fixture.shape = &edge;
        fixture.friction = friction;
        ground->CreateFixture(&fixture);
    }
    for (int k = 0; k < count; k++) {
        const double *row = rows + 5 * k;
        b2BodyDef definition;
        definition.type = b2_dynamicBody;
        definition.position.Set(row[0], row[1]);
        definition.angle = row[2];
        b2Body *body = pile->world.CreateBody(&definition);
        b2CircleShape disc;
        b2PolygonShape box;
        b2FixtureDef fixture;
        if (row[4] > 0.0) {
            box.SetAsBox(row[3], row[4]);
            fixture.shape = &box;
        } else {
            disc.m_radius = row[3];
            fixture.shape = &disc;
        }
        fixture.density = density;
        fixture.friction = friction;
        body->CreateFixture(&fixture);
        pile->bodies.push_back(body);
    }
    return pile;
}

void step(void *pile, int steps, double dt, int velocity, int position) {
    for (int k = 0; k < steps; k++) static_cast<Pile *>(pile)->world.Step(dt, velocity, position);
}

// Rows: x, y, angle, both components of the velocity, angular velocity.
void read(void *pile, double *rows) {
    for (b2Body *body : static_cast<Pile *>(pile)->bodies) {
        const b2Vec2 place = body->GetPosition(), velocity = body->GetLinearVelocity();
        for (double each : {double(place.x), double(place.y), double(body->GetAngle()), double(velocity.x),
                            double(velocity.y), double(body->GetAngularVelocity())})
            *rows++ = each;
    }
}
}
