// Moves a body as `livermark export BODY press_and_slide` writes it with Bullet, and writes what `livermark score`
// reads.
//
//   h5c++ -std=c++20 -isystem /usr/include/bullet examples/move_with_bullet.cpp
//     -lhdf5_hl -lBulletSoftBody -lBulletDynamics -lBulletCollision -lLinearMath -o move_with_bullet
//   ./move_with_bullet out/liver_healthy/press_and_slide.scene.h5 motion.h5
//
// Co-rotational linear tetrahedra (btDeformableLinearElasticityForce), implicit, one step in a frame, with the number
// of iterations that Bullet takes by itself. The tool has hold of its nodes, so nobody looks for contact.
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <vector>

/// Content of a scene file; see "Tool scenes" in results/schema.md.
struct Scene {
    std::vector<double> points, density, young_modulus, poisson_ratio, time, way;
    std::vector<int> tetrahedra, held, tool;
    double mass_damping = 0.0;
    int last_record_held = 0;

    int num_nodes() const { return static_cast<int>(points.size() / 3); }
    int num_records() const { return static_cast<int>(time.size()); }
};

[[noreturn]] void stop(const char *what) {
    std::fprintf(stderr, "move_with_bullet: %s\n", what);
    std::exit(2);
}

template <class T> std::vector<T> read(hid_t file, const char *path, hid_t type) {
    int rank = 0;
    hsize_t shape[3]{1, 1, 1};
    if (H5LTget_dataset_ndims(file, path, &rank) < 0 || H5LTget_dataset_info(file, path, shape, nullptr, nullptr) < 0)
        stop("this is no scene of livermark export");
    std::vector<T> values(shape[0] * shape[1] * shape[2]);
    H5LTread_dataset(file, path, type, values.data());
    return values;
}

Scene read_scene(const char *path) {
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0)
        stop("the scene cannot be read");
    Scene scene{.points = read<double>(file, "/points", H5T_NATIVE_DOUBLE),
                .density = read<double>(file, "/materials/density", H5T_NATIVE_DOUBLE),
                .young_modulus = read<double>(file, "/materials/young_modulus", H5T_NATIVE_DOUBLE),
                .poisson_ratio = read<double>(file, "/materials/poisson_ratio", H5T_NATIVE_DOUBLE),
                .time = read<double>(file, "/tool/time", H5T_NATIVE_DOUBLE),
                .way = read<double>(file, "/tool/displacement", H5T_NATIVE_DOUBLE),
                .tetrahedra = read<int>(file, "/tetrahedra", H5T_NATIVE_INT),
                .held = read<int>(file, "/held", H5T_NATIVE_INT),
                .tool = read<int>(file, "/tool/nodes", H5T_NATIVE_INT)};
    H5LTget_attribute_double(file, "/tool", "mass_damping", &scene.mass_damping);
    H5LTget_attribute_int(file, "/tool", "last_record_held", &scene.last_record_held);
    H5Fclose(file);
    if (scene.density.size() != 1)
        stop("the body has several materials, and a law of Bullet has one for all");
    return scene;
}

btVector3 vector(const std::vector<double> &values, std::size_t i) {
    return {static_cast<btScalar>(values[3 * i]), static_cast<btScalar>(values[3 * i + 1]),
            static_cast<btScalar>(values[3 * i + 2])};
}

/// A quarter of each tetrahedron at each of its nodes.
std::vector<btScalar> node_masses(const Scene &scene) {
    std::vector<btScalar> mass(scene.num_nodes(), 0.0F);
    for (std::size_t t = 0; t < scene.tetrahedra.size(); t += 4) {
        const int *nodes = &scene.tetrahedra[t];
        const btVector3 origin = vector(scene.points, nodes[0]);
        const btScalar volume = (vector(scene.points, nodes[1]) - origin)
                                    .cross(vector(scene.points, nodes[2]) - origin)
                                    .dot(vector(scene.points, nodes[3]) - origin) /
                                6.0F;
        for (int corner = 0; corner < 4; ++corner)
            mass[nodes[corner]] += static_cast<btScalar>(scene.density[0]) * volume / 4.0F;
    }
    return mass;
}

void append_tetrahedra(btSoftBody &body, const std::vector<int> &nodes) {
    for (std::size_t t = 0; t < nodes.size(); t += 4)
        body.appendTetra(nodes[t], nodes[t + 1], nodes[t + 2], nodes[t + 3]);
    body.m_tetraScratches.resize(body.m_tetras.size());
    body.m_tetraScratchesTn.resize(body.m_tetras.size());
    body.initializeDmInverse();
}

/// Displacements (K, N, 3) and forces (K, 3) of the body on the tool.
struct Motion {
    std::vector<float> displacement;
    std::vector<double> force;
    double seconds_per_frame = 0.0;
};

void keep(Motion &motion, const Scene &scene, const btSoftBody &body, const btVector3 &force) {
    for (int i = 0; i < scene.num_nodes(); ++i)
        for (int c = 0; c < 3; ++c)
            motion.displacement.push_back(static_cast<float>(body.m_nodes[i].m_x[c] - scene.points[3 * i + c]));
    for (int c = 0; c < 3; ++c)
        motion.force.push_back(force[c]);
}

btVector3 tool_force(const Scene &scene, btSoftBody &body, btDeformableLagrangianForce &law) {
    btDeformableLagrangianForce::TVStack forces;
    forces.resize(scene.num_nodes(), btVector3(0, 0, 0));
    body.updateDeformation();
    law.addScaledExplicitForce(1.0F, forces); // elastic alone
    btVector3 sum(0, 0, 0);
    for (const int node : scene.tool)
        sum += forces[node];
    return sum;
}

Motion move(const Scene &scene) {
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btDeformableBodySolver solver;
    btDeformableMultiBodyConstraintSolver constraints;
    constraints.setDeformableSolver(&solver);
    btDeformableMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &constraints, &configuration, &solver);
    world.setGravity({0, 0, 0});
    world.setImplicit(true);
    world.setUseProjection(true); // without it implicit steps have no preconditioner to go on with

    const auto mass = node_masses(scene);
    std::vector<btVector3> points;
    for (int i = 0; i < scene.num_nodes(); ++i)
        points.push_back(vector(scene.points, i));
    btSoftBody body(&world.getWorldInfo(), scene.num_nodes(), points.data(), mass.data());
    append_tetrahedra(body, scene.tetrahedra);
    body.m_cfg.collisions = 0;
    body.setActivationState(DISABLE_DEACTIVATION);
    for (const auto *nodes : {&scene.held, &scene.tool})
        for (const int node : *nodes)
            body.setMass(node, 0.0F); // Bullet: moves with its velocity, whatever pulls
    const double young = scene.young_modulus[0], poisson = scene.poisson_ratio[0];
    btDeformableLinearElasticityForce law(
        static_cast<btScalar>(young / (2.0 + 2.0 * poisson)),
        static_cast<btScalar>(young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))),
        static_cast<btScalar>(scene.mass_damping), 0.0F);
    world.addSoftBody(&body);
    world.addForce(&body, &law);

    Motion motion;
    keep(motion, scene, body, {0, 0, 0});
    std::clock_t ticks = 0;
    for (int k = 1; k < scene.num_records(); ++k) {
        const auto step = static_cast<btScalar>(scene.time[k] - scene.time[k - 1]);
        const bool is_held = k <= scene.last_record_held;
        for (std::size_t t = 0; t < scene.tool.size(); ++t) {
            auto &node = body.m_nodes[scene.tool[t]];
            if (is_held) // to where the tool is at the end of the frame
                node.m_v = node.m_vn =
                    (points[scene.tool[t]] + vector(scene.way, k * scene.tool.size() + t) - node.m_x) / step;
            else if (k == scene.last_record_held + 1)
                body.setMass(scene.tool[t], mass[scene.tool[t]]);
        }
        const std::clock_t start = std::clock();
        world.stepSimulation(step, 0);
        ticks += std::clock() - start;
        keep(motion, scene, body, is_held ? tool_force(scene, body, law) : btVector3(0, 0, 0));
    }
    motion.seconds_per_frame = static_cast<double>(ticks) / CLOCKS_PER_SEC / (scene.num_records() - 1);
    world.removeSoftBody(&body);
    return motion;
}

void write(const char *path, const Scene &scene, const Motion &motion) {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
    const hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, access);
    if (file < 0)
        stop("the motion cannot be written");
    const auto num_records = static_cast<hsize_t>(scene.num_records());
    const hsize_t fields[3]{num_records, static_cast<hsize_t>(scene.num_nodes()), 3}, forces[2]{num_records, 3};
    H5LTmake_dataset_float(file, "/displacement", 3, fields, motion.displacement.data());
    H5LTmake_dataset_double(file, "/force", 2, forces, motion.force.data());
    const hid_t scalar = H5Screate(H5S_SCALAR);
    const hid_t cost = H5Acreate2(file, "seconds_per_frame", H5T_NATIVE_DOUBLE, scalar, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(cost, H5T_NATIVE_DOUBLE, &motion.seconds_per_frame);
    H5Aclose(cost);
    H5Sclose(scalar);
    H5Fclose(file);
    H5Pclose(access);
}

int main(int argc, char **argv) {
    if (argc != 3)
        stop("usage: move_with_bullet SCENE.h5 MOTION.h5");
    const Scene scene = read_scene(argv[1]);
    write(argv[2], scene, move(scene));
}
